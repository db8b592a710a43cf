// Presses or grasps a tissue over UDP: UdpPress.exe press|grasp PORT X Y Z DX DY DZ [SECONDS [HZ]]
// The device moves from outside to the contact X Y Z [m] and on by the tool displacement DX DY DZ [m], and back. With
// `grasp` the tool grasps where it is deepest, lifts the tissue out by a quarter of the displacement, and lets go. It
// sends HZ positions a second (1000) and prints the forces on the hand [N]. udp_press.cpp is the same in C++.
// Start `tissue-haptic MODEL --device remote --port PORT` first. Build: mcs UdpPress.cs UdpDevice.cs
using System;
using System.Globalization;
using System.Threading;

static class UdpPress
{
    static int Main(string[] argument)
    {
        bool grasps = argument.Length > 0 && argument[0] == "grasp";
        bool known = argument.Length >= 8 && argument.Length <= 10 && (grasps || argument[0] == "press");
        double[] number = { 0, 0, 0, 0, 0, 0, 0, 2, 1000 };  // port, contact, displacement, seconds, rate
        for (int k = 1; known && k < argument.Length; ++k)
            known = double.TryParse(argument[k], NumberStyles.Float, CultureInfo.InvariantCulture, out number[k - 1]) && Math.Abs(number[k - 1]) < 1e9;
        double depth = Math.Sqrt(number[4] * number[4] + number[5] * number[5] + number[6] * number[6]), seconds = number[7], rate = number[8];
        if (!known || number[0] < 1 || number[0] > 65535 || depth == 0 || seconds <= 0 || rate <= 0)
        {
            Console.Error.WriteLine("usage: UdpPress.exe press|grasp PORT X Y Z DX DY DZ [SECONDS [HZ]]");
            return 2;
        }

        using (var device = new UdpDevice((int)number[0]))
        {
            double pushed = 0, pulled = 0, last = 0, begin = device.Now;
            var force = new double[3];
            for (long tick = 1; device.Now - begin < seconds; ++tick)
            {
                double turn = (device.Now - begin) / seconds;
                double at = -0.4 + 1.4 * Math.Pow(Math.Sin(Math.PI * turn), 2);  // outside by 0.4 of the displacement, in, out
                device.Send(number[1] + at * number[4], number[2] + at * number[5], number[3] + at * number[6], grasps && turn > 0.5 && turn < 0.9);
                double wait = begin + tick / rate - device.Now;
                if (wait > 0) Thread.Sleep(TimeSpan.FromSeconds(wait));
                device.Receive(force);
                last = Math.Sqrt(force[0] * force[0] + force[1] * force[1] + force[2] * force[2]);
                double along = (force[0] * number[4] + force[1] * number[5] + force[2] * number[6]) / depth;
                pushed = Math.Max(pushed, -along);
                pulled = Math.Max(pulled, along);
            }
            Console.WriteLine(string.Format(CultureInfo.InvariantCulture,
                "the tissue pushed with up to {0:F4} N, pulled with up to {1:F4} N, at the end {2:F4} N", pushed, pulled, last));
            Console.WriteLine("sent " + device.Sent + ", answers " + device.Answers + ", refused " + device.Refused);
            return device.Answers > 0 ? 0 : 1;
        }
    }
}
