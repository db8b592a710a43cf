// UdpDevice: the client's end of `tissue-haptic MODEL --device remote`, for an engine in C# such as Unity.
//
// It needs System.Net.Sockets alone, and links nothing of tissuectl: an engine under any licence talks to the program
// as a process of its own. cli/view/PROTOCOL.md has the datagrams. SI units, axes of the tissue.
//
// One thread owns a device. Either it sends and receives once every millisecond (a device with motors), or once in
// every frame (a tracked controller, a mouse). Send a position when it has been measured, not again: the program takes
// the hand's speed from the time between two measurements. Positions at 25 Hz or fewer are too old (option stale).
// Neither call allocates, except where the system refuses a datagram.
using System;
using System.Diagnostics;
using System.IO;
using System.Net;
using System.Net.Sockets;

public sealed class UdpDevice : IDisposable
{
    const int Remembered = 1024;  // positions whose time is kept
    const int Size = 48;          // of both datagrams

    readonly double forceMax, held;
    readonly Stopwatch clock = Stopwatch.StartNew();
    readonly Socket socket = new Socket(AddressFamily.InterNetwork, SocketType.Dgram, ProtocolType.Udp);
    readonly byte[] output = new byte[Size], input = new byte[Size + 1];
    readonly BinaryWriter writer;  // little-endian on every platform, as datagrams are
    readonly BinaryReader reader;
    readonly double[] sentAt = new double[Remembered], newest = new double[3];
    uint sequence;
    double computedAt = double.NegativeInfinity;  // when the program computed `newest`, by the clock of this client

    // Numbers of positions sent, forces used, and datagrams refused.
    public long Sent { get { return sequence; } }
    public long Answers { get; private set; }
    public long Refused { get; private set; }

    // Monotonic time since the start [s].
    public double Now { get { return clock.Elapsed.TotalSeconds; } }

    // port: of tissue-haptic on this machine. forceMax: longest force that Receive returns [N]; 3.3 is a Touch's.
    // held: how long a force is valid [s]; 0.0075 is three quarters of the 0.01 s after which the energy log of
    // tissue-haptic assumes that the device has released it. Throws SocketException where there is no socket.
    public UdpDevice(int port, double forceMax = 3.3, double held = 0.0075)
    {
        this.forceMax = forceMax;
        this.held = held;
        writer = new BinaryWriter(new MemoryStream(output));
        reader = new BinaryReader(new MemoryStream(input));
        socket.Blocking = false;
        socket.Connect(new IPEndPoint(IPAddress.Loopback, port));  // a connected socket receives nothing from other programs
    }

    public void Dispose() { socket.Dispose(); }

    // A position that has just been measured [m]. grasp: whether the tool grasps the tissue that it touches.
    public void Send(double x, double y, double z, bool grasp)
    {
        double time = Now;
        sentAt[++sequence % Remembered] = time;
        writer.BaseStream.Position = 0;
        writer.Write((byte)'T'); writer.Write((byte)'S'); writer.Write((byte)'P'); writer.Write((byte)'1');
        writer.Write(sequence);
        writer.Write(time);
        writer.Write(x); writer.Write(y); writer.Write(z);
        writer.Write(grasp ? 1.0 : 0.0);
        try { socket.Send(output); }
        catch (SocketException) { }  // the program does not listen yet, or follows another client: the next one comes soon
    }

    // Takes the forces that have arrived, and writes the force on the hand [N] to `force`, three numbers. Zero without a
    // force of the last `held` seconds: a device with motors must call this at least that often, and release its force
    // when it stops.
    public void Receive(double[] force)
    {
        for (int k = 0; k < 512 && socket.Poll(0, SelectMode.SelectRead); ++k)  // more than the system keeps: a flood ends
        {
            try { Take(socket.Receive(input)); }
            catch (SocketException e) { if (e.SocketErrorCode != SocketError.ConnectionRefused) ++Refused; }
        }
        bool valid = Now - computedAt <= held;
        for (int k = 0; k < 3; ++k) force[k] = valid ? newest[k] : 0;
    }

    void Take(int size)
    {
        if (size != Size || input[0] != 'T' || input[1] != 'S' || input[2] != 'F' || input[3] != '1') { ++Refused; return; }
        reader.BaseStream.Position = 4;
        uint used = reader.ReadUInt32();
        double age = reader.ReadDouble(), x = reader.ReadDouble(), y = reader.ReadDouble(), z = reader.ReadDouble();
        double length = Math.Sqrt(x * x + y * y + z * z);
        // it must answer one of the last positions; the first has sequence 1
        if (unchecked(sequence - used) >= Math.Min(sequence, Remembered) || !(length < double.MaxValue) || !(Math.Abs(age) < double.MaxValue)) { ++Refused; return; }
        double share = length > forceMax ? forceMax / length : 1;
        newest[0] = share * x; newest[1] = share * y; newest[2] = share * z;
        // by the position's time: a force that has waited in the socket while this program stalled is old
        computedAt = Math.Min(sentAt[used % Remembered] + age, Now);
        ++Answers;
    }
}
