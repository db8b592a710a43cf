#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "../allocations.h"
#include "../example.h"
#include "../refusal.h"
#include "error.h"
#include "haptic/realtime_loop.h"
#include "haptic/recorder.h"
#include "haptic/remote_device.h"
#include "haptic/replay_device.h"
#include "haptic/state_channel.h"
#include "haptic/virtual_device.h"
#include "haptic_example.h"
#include "io/atomic_file.h"
#include "stand_in.h"

using namespace tissue;

namespace {

/// Quotes a word of a shell command inside '...'.
std::string quoted(const std::string& word) {
    return '"' + word + '"';
}

/// Path of the program, quoted: TISSUE_HAPTIC, or the one that was built beside these tests.
std::string program() {
    const char* given = std::getenv("TISSUE_HAPTIC");
    return quoted(given ? given : (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "tissue-haptic").string());
}

/// Shell code that waits until the program, process $child, has printed its first messages or has ended.
std::string until_it_runs(const TemporaryFolder& folder) {
    return "until grep -qs coupling " + folder.file("err") + " || ! kill -0 $child; do sleep 0.05; done; ";
}

struct Ended {
    int status;
    std::string out, err;
};

/// Runs the program in a shell. signal: "TERM", for instance, is sent half a second after the first messages.
Ended run(const TemporaryFolder& folder, const std::string& arguments, const std::string& signal = "") {
    std::string command = program() + " " + arguments + " > " + folder.file("out") + " 2> " + folder.file("err");
    if (!signal.empty())
        command += " & child=$!; " + until_it_runs(folder) + "sleep 0.5; kill -" + signal + " $child; wait $child";
    const int status = std::system(("sh -c '" + command + "'").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(folder.file("out")), read_file(folder.file("err"))};
}

std::string model_file(const TemporaryFolder& folder) {
    const std::string file = folder.file("model.h5");
    write_model(file, haptic_example(), {"test", 1, {}});
    return file;
}

}  // namespace

TEST_CASE("a model in space plays with statistics and a recording along three axes that replays", "[tissue-haptic][solid][long]") {
    const TemporaryFolder folder;
    write_model(folder.file("solid.h5"), solid_example(), {"test", 1, {}});
    const std::string play = folder.file("solid.h5") + " --no-clock --json --seconds 1.5";
    const Ended ended = run(folder, play + " --motion press --depth 0.005 --record " + folder.file("record.h5"));
    INFO(ended.err);
    REQUIRE(ended.status == 0);
    const auto statistics = nlohmann::json::parse(ended.out);
    CHECK(statistics["force_max_N"].get<double>() > 0.05);
    CHECK(statistics["bad_input"] == 0);
    {
        const Hdf5Reader in(folder.file("record.h5"), "recording");
        const NodeField master = in.field("/master"), force = in.field("/coupling_force"), weight = in.field("/weight");
        REQUIRE(master.cols() == 3);
        REQUIRE(weight.cols() == 3);
        CHECK(master(master.rows() - 1, 2) == Approx(0.045).margin(1e-4));
        CHECK(force(force.rows() - 1, 2) > 0.05);
        CHECK(weight.row(weight.rows() - 1).sum() == Approx(1));
    }
    const Ended again = run(folder, play + " --device replay --trajectory " + folder.file("record.h5"));
    REQUIRE(again.status == 0);
    CHECK(nlohmann::json::parse(again.out)["force_max_N"].get<double>() > 0.05);
    for (const std::string& wrong : {std::string(" --sets optimum"), std::string(" --axes x,y"), std::string(" --offset 0 0")}) {
        const Ended refused = run(folder, play + wrong);
        CHECK(refused.status == 1);
        CHECK(std::count(refused.err.begin(), refused.err.end(), '\n') == 1);
    }
}

TEST_CASE("a ring keeps the order between two threads and refuses items only when it is full", "[recorder]") {
    SpscRing<int> ring(1000);
    CHECK(ring.capacity() == 1024);
    for (int k = 0; k < 1024; ++k) REQUIRE(ring.push(k));
    CHECK_FALSE(ring.push(0));
    int item = -1;
    for (int k = 0; k < 1024; ++k) REQUIRE((ring.pop(item) && item == k));
    CHECK_FALSE(ring.pop(item));

    long long sum = 0;
    std::thread reader([&] {
        int next = 0, got;
        while (next < 200000)
            if (ring.pop(got)) {
                if (got != next) return;
                sum += got;
                ++next;
            }
    });
    for (int k = 0; k < 200000;)
        if (ring.push(k)) ++k;
    reader.join();
    CHECK(sum == 200000ll * 199999 / 2);
}

TEST_CASE("percentiles of durations are within 1 % and the largest is exact", "[recorder]") {
    Histogram h;
    CHECK(h.percentile(0.5) == 0);
    for (int k = 1; k <= 10000; ++k) h.add(k);
    CHECK(h.percentile(0.5) == Approx(5000).epsilon(0.011));
    CHECK(h.percentile(0.999) == Approx(9990).epsilon(0.011));
    CHECK(h.percentile(1) == 10000);
    CHECK(h.max() == 10000);
}

TEST_CASE("a recorded session replays to bitwise equal forces", "[recorder]") {
    const bool is_energy_model = GENERATE(false, true);
    const TemporaryFolder folder;
    HapticOptions o;
    o.map.force_scale = 100;
    const HapticModel model(is_energy_model ? energy_model_example() : haptic_example(), o);
    {
        // in simulated time: no tick is missed
        Simulation simulation(model);
        VirtualDevice hand(make_motion({"poke", 2, 0.01, 4, &model.rest}), o.map);
        Recorder recorder(folder.file("a.h5"), 2, {"test", 4, {}});
        for (int k = 0; k < 2000; ++k) {
            simulation.tick(hand.read(k * 1e-3));
            RecordedTick row{{simulation.record()}, 0, 1, 2};
            row.time_s = k * 1e-3;
            recorder.push(row);
        }
        recorder.close(simulation);
        CHECK(recorder.dropped() == 0);
        CHECK(simulation.safety().counters().force_max_N > 0.05);
    }
    const Hdf5Reader in(folder.file("a.h5"), "recording");
    CHECK(in.number_attribute("/", "force_scale") == 100);
    CHECK(in.number_attribute("/", "dropped_samples") == 0);
    const NodeField force = in.field("/device_force");
    REQUIRE(force.rows() == 2000);
    Simulation again(model);
    ReplayDevice replay(folder.file("a.h5"));
    for (int k = 0; k < 2000; ++k) {
        const Eigen::Vector3d f = again.tick(replay.read(k * 1e-3));
        replay.write(f);
        REQUIRE(f == force.row(k).transpose());
    }
    CHECK(replay.finished());
    for (const auto& [name, value] : replay.statistics())
        if (name != "reference_rms_N") CHECK(value == 0);
}

TEST_CASE("a recording with resets on tissue that relaxes replays to bitwise equal forces", "[recorder][memory]") {
    const bool solid = GENERATE(false, true);
    const TemporaryFolder folder;
    const HapticModel model(relaxing(solid ? solid_example() : energy_model_example()), {});
    {
        Simulation simulation(model);
        StateChannel page(model);
        VirtualDevice hand(make_motion({"poke", 3, solid ? 0.003 : 0.01, 4, &model.rest}), model.options.map);
        Recorder recorder(folder.file("a.h5"), model.dimension(), {"test", 4, {}});
        for (int k = 0; k < 3000; ++k) {
            if (k % 700 == 650) page.reset();
            const bool paused = k % 700 == 651;  // a reset during a pause
            if (paused) page.reset();
            page.before(simulation);
            if (paused) continue;
            simulation.tick(hand.read(k * 1e-3));
            TickStatistics books;
            books.time_s = k * 1e-3;
            recorder.after(simulation, books);
        }
        recorder.close(simulation);
        REQUIRE(recorder.dropped() == 0);
        CHECK(simulation.safety().counters().force_max_N > 0.05);
    }
    const Hdf5Reader in(folder.file("a.h5"), "recording");
    const NodeField force = in.field("/device_force");
    const std::vector<int> reset = in.integers("/reset");
    const Eigen::VectorXd time = in.vector("/time");
    CHECK(std::count(reset.begin(), reset.end(), 1) == 8);
    for (bool forgetting : {true, false}) {  // without its resets it gives other forces
        Simulation again(model);
        ReplayDevice replay(folder.file("a.h5"));
        double off_N = 0;
        for (Eigen::Index k = 0; k < time.size(); ++k) {
            DeviceSample sample = replay.read(time[k]);
            CHECK(sample.reset == (reset[static_cast<std::size_t>(k)] == 1));
            sample.reset = sample.reset && forgetting;
            off_N = std::max(off_N, (again.tick(sample) - force.row(k).transpose()).norm());
        }
        if (forgetting) CHECK(off_N == 0);
        else CHECK(off_N > 1e-3);
        CHECK(replay.finished());
    }
}

TEST_CASE("a recording without a reset column replays and one with a short column is refused", "[recorder]") {
    const TemporaryFolder folder;
    const auto recording = [&](const std::string& name, int resets) {
        Hdf5Writer out(folder.file(name), "recording", {"test", 1, {}});
        out.write("/time", Eigen::VectorXd::LinSpaced(3, 0, 0.002).eval(), "s", "");
        out.write("/device_position", NodeField(NodeField::Zero(3, 3)), "m", "");
        out.write("/device_force", NodeField(NodeField::Zero(3, 3)), "N", "");
        if (resets > 0) out.write_integers("/reset", {static_cast<std::size_t>(resets)}, std::vector<int>(static_cast<std::size_t>(resets), 1), "");
        out.commit();
        return folder.file(name);
    };
    ReplayDevice replay(recording("earlier.h5", 0));
    CHECK_FALSE(replay.read(0).reset);
    CHECK_FALSE(replay.read(0.002).reset);
    ReplayDevice late(recording("late.h5", 3));
    CHECK(late.read(0.002).reset);  // also where a late tick skips rows
    CHECK_FALSE(late.read(0.002).reset);
    const std::string why = refusal<FileError>([&] { ReplayDevice(recording("short.h5", 2)); });
    CHECK(why.find("/reset") != std::string::npos);
}

TEST_CASE("a full ring drops samples and the recording states their number", "[recorder]") {
    const TemporaryFolder folder;
    const HapticModel model(haptic_example(), {});
    Recorder recorder(folder.file("a.h5"), 2, {"test", 1, {}}, 1, 16);
    for (int k = 0; k < 100000; ++k) {
        RecordedTick row;
        row.time_s = k;
        recorder.push(row);
    }
    recorder.close(Simulation(model));
    const Hdf5Reader in(folder.file("a.h5"), "recording");
    CHECK(recorder.dropped() > 0);
    CHECK(in.number_attribute("/", "dropped_samples") == static_cast<double>(recorder.dropped()));
    CHECK(in.vector("/time").size() + recorder.dropped() == 100000);
    refusal<FileError>([&] { Recorder(folder.file("no/such/folder.h5"), 2, {"test", 1, {}}); });
}

TEST_CASE("a recording is written during the session in bounded memory and its file appears at the end", "[recorder]") {
    const TemporaryFolder folder;
    const HapticModel model(haptic_example(), {});
    const auto resident = [] {
        long total = 0, pages = 0;
        std::ifstream("/proc/self/statm") >> total >> pages;
        return static_cast<double>(pages) * static_cast<double>(::sysconf(_SC_PAGESIZE));
    };
    constexpr int batches = 40, batch = 4000;
    Recorder recorder(folder.file("a.h5"), 2, {"test", 1, {}});
    double begin = 0;
    for (int k = 0; k < batches * batch; ++k) {
        RecordedTick row;
        row.time_s = k;
        row.tool[0].status = static_cast<TickStatus>(k % 5);
        recorder.push(row, true);
        if (k == 5 * batch) begin = resident();  // ring, block and HDF5's own buffers are allocated
    }
    const double grown = resident() - begin, taken = static_cast<double>((batches - 5) * batch) * sizeof(RecordedTick);
    const auto beside = static_cast<double>(std::filesystem::file_size(folder.file(folder.names().at(0))));
    CHECK_FALSE(std::filesystem::exists(folder.file("a.h5")));
    recorder.close(Simulation(model));
    const Eigen::VectorXd time = Hdf5Reader(folder.file("a.h5"), "recording").vector("/time");
    CHECK(recorder.dropped() == 0);
    CHECK(time.size() == batches * batch);
    const std::vector<int> status = Hdf5Reader(folder.file("a.h5"), "recording").integers("/status");
    REQUIRE(status.size() == static_cast<std::size_t>(time.size()));
    CHECK((status[3] == static_cast<int>(TickStatus::folded) && status[5] == static_cast<int>(TickStatus::done) && status.back() == static_cast<int>(TickStatus::diverged)));
    CHECK((time.tail(time.size() - 1) - time.head(time.size() - 1)).minCoeff() > 0);
    CHECK(beside > 0.5 * static_cast<double>(std::filesystem::file_size(folder.file("a.h5"))));
    CHECK(folder.names() == std::vector<std::string>{"a.h5"});
    INFO(grown << " bytes more for " << taken << " bytes of ticks");
    if (Allocations::seen()) CHECK(grown < 0.2 * taken);  // a sanitizer keeps freed memory
}

TEST_CASE("an abandoned recording leaves nothing and keeps the previous file", "[recorder]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a.h5", "an earlier session");
    {
        Recorder recorder(file, 2, {"test", 1, {}});
        for (int k = 0; k < 3000; ++k) recorder.push({});
    }
    CHECK(read_file(file) == "an earlier session");
    CHECK(folder.names() == std::vector<std::string>{"a.h5"});
}

TEST_CASE("the loop keeps its schedule over missed ticks and ends with zero force", "[loop]") {
    /// A hand that delays the loop by 20 ms in its 50th tick by sleeping, which is no work of the program.
    class Sleepy final : public Device {
       public:
        std::string name() const override { return "sleepy"; }
        DeviceSample read(double time_s) noexcept override {
            last_s = time_s;
            asked = true;
            if (++reads == 50) std::this_thread::sleep_for(std::chrono::milliseconds(20));
            return sample_at(0.05, 0.104 - 5e-5 * reads);  // deeper in each tick
        }
        void write(const Eigen::Vector3d& f) noexcept override {
            force = f;
            if (std::exchange(asked, false)) last_answer = f.norm();
        }
        bool finished() const noexcept override { return reads == 150; }  // however few ticks a busy machine allows
        int reads = 0;
        double last_s = 0, last_answer = 0;
        bool asked = false;
        Eigen::Vector3d force{1, 1, 1};
    } device;
    const HapticModel model(haptic_example(), {});
    Simulation simulation(model);
    LoopOptions o;
    o.seconds = 0;
    o.realtime = false;
    const LoopReport report = run_loop(simulation, device, o);
    CHECK(report.misses >= 20);
    // a sleep takes no processor time; a busy machine may add overruns that do
    CHECK(report.misses_program <= report.misses - 15);
    CHECK(report.ticks == 150);
    CHECK(report.ticks == device.reads);
    // Place of the last tick on the schedule: every tick and every overrun before it has one.
    CHECK(device.last_s > 1e-3 * (150 + 20 - 1.5));
    CHECK(device.last_s < 1e-3 * (static_cast<double>(report.ticks + report.misses) - 0.5));
    CHECK(device.last_answer > 0);  // in contact until the end
    CHECK(device.force == Eigen::Vector3d::Zero());
    CHECK(report.tick_us.max() > 4900);
}

TEST_CASE("tissue-haptic prints statistics as JSON with every key and records every tick", "[program]") {
    const TemporaryFolder folder;
    const Ended ended = run(folder, model_file(folder) + " --seconds 1 --motion poke --json --force-scale 3 --record " + folder.file("s.h5"));
    INFO(ended.err);
    REQUIRE(ended.status == 0);
    const nlohmann::json j = nlohmann::json::parse(ended.out);
    for (const char* key : {"model", "device", "ticks", "misses", "misses_program", "tick_us", "lateness_us", "dropped_samples",
                            "force_max_N", "clamped", "energy_given_J", "bad_input"})
        CHECK(j.count(key) == 1);
    for (const char* key : {"p50", "p99", "p999", "max"}) CHECK((j["tick_us"].count(key) == 1 && j["lateness_us"].count(key) == 1));
    CHECK(j["device"] == "virtual");
    CHECK(j["ticks"].get<int>() + j["misses"].get<int>() == 1000);
    CHECK(j["bad_input"] == 0);
    CHECK(ended.err.find("force scale 3") != std::string::npos);
    CHECK(ended.err.find("omega dt") != std::string::npos);
    const Hdf5Reader in(folder.file("s.h5"), "recording");
    CHECK(in.vector("/time").size() == j["ticks"].get<int>());
    CHECK(in.number_attribute("/", "force_scale") == 3);
    CHECK(in.text_attribute("/", "dynamics_learned") == "symplectic");

    const Ended replayed = run(folder, model_file(folder) + " --device replay --trajectory " + folder.file("s.h5") + " --force-scale 3 --seconds 0 --json");
    REQUIRE(replayed.status == 0);
    CHECK(nlohmann::json::parse(replayed.out)["details"]["device"].count("reference_error_rms_N") == 1);

    const std::string leaps = folder.file("leaps.csv", "time_s,x_m,y_m\n0,0.05,0.12\n0.1,0.05,0.12\n0.1005,0.05,0.2\n0.2,0.05,0.2\n0.2005,0.05,0.12\n0.3,0.05,0.12\n");
    const Ended leapt = run(folder, model_file(folder) + " --no-clock --device replay --trajectory " + leaps + " --seconds 0 --json");
    REQUIRE(leapt.status == 0);
    const nlohmann::json statistics = nlohmann::json::parse(leapt.out), &details = statistics["details"];
    CHECK(details["jumps"].get<int>() > 0);
    CHECK(statistics["bad_input"] == details["not_finite"].get<int>() + details["jumps"].get<int>() + details["stale"].get<int>());
}

TEST_CASE("tissue-haptic plays and records and replays an energy model and refuses options of spring sets", "[program]") {
    const TemporaryFolder folder;
    const std::string model = folder.file("law.h5");
    write_model(model, energy_model_example(), {"test", 1, {}});
    const Ended ended = run(folder, model + " --no-clock --seconds 1 --motion sine --json --record " + folder.file("s.h5"));
    INFO(ended.err);
    REQUIRE(ended.status == 0);
    CHECK(ended.err.find("an energy model") != std::string::npos);
    const nlohmann::json j = nlohmann::json::parse(ended.out);
    CHECK(j["details"]["dynamics"]["learned"]["substeps"] == 3);
    CHECK(j["force_max_N"] > 0.1);
    const Hdf5Reader in(folder.file("s.h5"), "recording");
    CHECK(in.texts("/set_names").empty());
    CHECK(in.vector("/time").size() == 1000);
    CHECK(run(folder, model + " --no-clock --device replay --trajectory " + folder.file("s.h5") + " --seconds 0").status == 0);
    for (const char* option : {"--sets optimum", "--select-by force", "--dynamics implicit"}) {
        const Ended refused = run(folder, model + " " + option);
        CHECK(refused.status == 1);
        CHECK(std::count(refused.err.begin(), refused.err.end(), '\n') == 1);
        CHECK(refused.err.find("energy model") != std::string::npos);
    }
}

TEST_CASE("tissue-haptic plays an energy model that relaxes and refuses --check for it", "[program][memory]") {
    const TemporaryFolder folder;
    const std::string model = folder.file("law.h5");
    write_model(model, relaxing(energy_model_example()), {"test", 1, {}});
    const Ended ended = run(folder, model + " --no-clock --seconds 1 --motion press --json --energy-book");
    INFO(ended.err);
    REQUIRE(ended.status == 0);
    const auto statistics = nlohmann::json::parse(ended.out);
    CHECK(statistics["force_max_N"] > 0.1);
    // While the hand holds its place, its work is partly stored in Maxwell branches and partly dissipated.
    const double given_J = -statistics["energy_given_J"].get<double>(), stored_J = statistics["details"]["branches"]["stored_J"], dissipated_J = statistics["details"]["branches"]["dissipated_J"];
    CHECK(stored_J > 0);
    CHECK(dissipated_J > 0);
    CHECK(stored_J + dissipated_J < given_J);
    const Ended refused = run(folder, model + " --check " + model + " --out " + folder.file("r.json"));
    CHECK(refused.status == 1);
    CHECK(std::count(refused.err.begin(), refused.err.end(), '\n') == 1);
    CHECK(refused.err.find("this model relaxes") != std::string::npos);
}

TEST_CASE("tissue-haptic ends with statistics and a closed recording on SIGINT and SIGTERM and SIGHUP", "[program]") {
    // Under nohup the program ignores a hangup. The test must not inherit that.
    struct Hangup {
        void (*before)(int) = std::signal(SIGHUP, SIG_DFL);
        ~Hangup() { std::signal(SIGHUP, before); }
    } const hangup;
    for (const char* signal : {"TERM", "INT", "HUP"}) {
        const TemporaryFolder folder;
        const Ended ended = run(folder, model_file(folder) + " --seconds 0 --json --record " + folder.file("s.h5"), signal);
        CHECK(ended.status == 0);
        const nlohmann::json j = nlohmann::json::parse(ended.out);
        CHECK(j["ticks"].get<int>() > 0);
        const Hdf5Reader in(folder.file("s.h5"), "recording");
        CHECK(in.vector("/time").size() == j["ticks"].get<int>());
        for (const std::string& name : folder.names()) CHECK(name.find(".tmp") == std::string::npos);
    }
}

TEST_CASE("a session whose messages are not read still writes its recording", "[program][recorder]") {
    const TemporaryFolder folder;
    const std::string model = model_file(folder), file = folder.file("s.h5");
    const std::string command = program() + " " + model + " --no-clock --seconds 0.5 --motion poke --record " + file + " 2>&1 >/dev/null | true";
    CHECK(std::system(("sh -c '" + command + "'").c_str()) == 0);
    for (int k = 0; k < 100 && !std::filesystem::exists(file); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    CHECK(Hdf5Reader(file, "recording").vector("/time").size() == 500);
}

TEST_CASE("two devices of tissue-haptic have their own tools and options and statistics and recordings that replay both", "[program][two]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("law.h5"), recording = folder.file("two.h5");
    write_model(file, energy_model_example(), {"test", 1, {}});
    const std::string play = file + " --no-clock --json";
    const Ended ended = run(folder, play + " --seconds 1.5 --motion press --aside -0.025 --depth 0.006 --second-device virtual --second-motion sine --second-aside 0.025 --second-depth 0.004 --second-force-scale 2 --second-force-max 0.05 --record " + recording);
    INFO(ended.err);
    REQUIRE(ended.status == 0);
    const auto statistics = nlohmann::json::parse(ended.out);
    CHECK(statistics["force_max_N"].get<double>() > 0.1);
    CHECK(statistics["clamped"] == 0);
    CHECK(statistics["details"]["force_scale"] == 1);
    CHECK(statistics["second"]["device"] == "virtual");
    CHECK(statistics["second"]["force_max_N"].get<double>() == Approx(0.05));
    CHECK(statistics["second"]["clamped"].get<int>() > 100);
    CHECK(statistics["second"]["details"]["force_scale"] == 2);
    NodeField force[2];
    {
        const Hdf5Reader in(recording, "recording");
        force[0] = in.field("/device_force"), force[1] = in.field("/second/device_force");
        REQUIRE(force[0].rows() == 1500);
        REQUIRE(force[1].rows() == 1500);
        CHECK(force[0].row(1499).norm() > 0.1);
        CHECK(in.field("/master")(1499, 0) < 0.03);
        CHECK(in.field("/second/master")(800, 0) > 0.07);
        CHECK(in.number_attribute("/second", "force_scale") == 2);
        CHECK(in.number_attribute("/second", "force_max_N") == 0.05);
    }
    // The replay gives both devices the recorded forces.
    const Ended again = run(folder, play + " --device replay --trajectory " + recording + " --second-device replay --second-trajectory " + recording + " --second-force-scale 2 --second-force-max 0.05 --record " + folder.file("again.h5"));
    INFO(again.err);
    REQUIRE(again.status == 0);
    const auto replayed = nlohmann::json::parse(again.out);
    INFO(ended.out << again.out);
    CHECK(replayed["details"]["device"]["reference_rms_N"].get<double>() > 0.02);
    CHECK(replayed["details"]["device"]["reference_error_max_N"] == 0);
    CHECK(replayed["second"]["details"]["device"]["reference_rms_N"].get<double>() > 0.01);
    CHECK(replayed["second"]["details"]["device"]["reference_error_max_N"] == 0);
    // Combinations that are refused.
    const auto refused = [&](const std::string& arguments, int status) {
        const Ended e = run(folder, file + arguments);
        CHECK(e.status == status);
        return e.err;
    };
    CHECK(refused(" --second-motion poke", 2).find("--second-device") != std::string::npos);
    CHECK(refused(" --second-device replay", 2).find("needs --second-trajectory FILE") != std::string::npos);
    CHECK(refused(" --second-device virtual --second-port 5001", 2).find("--second-port") != std::string::npos);
    CHECK(refused(" --second-device virtual --second-friction -1", 2).find("the second tool: friction must lie in") != std::string::npos);
    CHECK(refused(" --friction 0.5 --friction-slip 0.4 --second-device virtual --second-friction 0.3", 2).find("the second tool: ") != std::string::npos);
    CHECK(refused(" --second-device virtual --second-passivity maybe", 2).find("--second-passivity: passivity must be one of yes, no") != std::string::npos);
    CHECK(refused(" --device remote --second-device remote", 2).find("--second-port") != std::string::npos);
    CHECK(refused(" --device remote --port 5000 --second-device remote --second-port 05000", 2).find("--second-port") != std::string::npos);
    CHECK(refused(" --device haply --second-device haply", 2).find("--second-haply-device-id") != std::string::npos);
    CHECK(refused(" --motion poke --aside 0.01", 1).find("--aside has no effect") != std::string::npos);
    CHECK(refused(" --aside 0.06", 1).find("aside must be within 0.05 m") != std::string::npos);
    CHECK(refused(" --second-device virtual --learn l.h5", 2).find("--second-device") != std::string::npos);
    CHECK(refused(" --device openhaptics --second-device openhaptics", 2).find("only one device openhaptics") != std::string::npos);
    CHECK(refused(" --second-device virtual --second-device-mass 0.0001 --no-clock", 1).find("the second tool: the stiffness of the learned mesh at the device is up to") != std::string::npos);
    write_model(folder.file("sets.h5"), haptic_example(), {"test", 1, {}});
    CHECK(run(folder, folder.file("sets.h5") + " --second-device virtual").err.find("two tools need an energy model") != std::string::npos);
}

TEST_CASE("tissue-haptic plays on the force-dimension stand-in and prints its type and its last error and limits the force to 8 N", "[program]") {
    const StandIn vendor("libdrd");
    const auto played = [&](const std::string& arguments) {
        return run(vendor.folder, model_file(vendor.folder) + " --device force-dimension --drd-library " + vendor.library + " --seconds 0.3 --force-max 20 " + arguments);
    };
    const Ended without = played("--json");
    INFO(without.err);
    REQUIRE(without.status == 0);
    CHECK(without.err.find("device force-dimension (omega.7)") != std::string::npos);
    CHECK(without.err.find("at most 8 N") != std::string::npos);
    const nlohmann::json j = nlohmann::json::parse(without.out);
    CHECK(j["device"] == "force-dimension (omega.7)");
    CHECK(j["details"]["device"]["servo_ticks"] > 10);
    CHECK(j["details"].count("device_error") == 0);
    const std::string fails = "STAND_IN_FORCE_ERRORS";
    ::setenv(fails.c_str(), "3", 1);
    const Ended text = played(""), json = played("--json");
    ::unsetenv(fails.c_str());
    CHECK(text.out.find("device error     timeout (vendor error 7)\n") != std::string::npos);
    REQUIRE(json.status == 0);
    CHECK(nlohmann::json::parse(json.out)["details"]["device_error"] == "timeout (vendor error 7)");
    CHECK(nlohmann::json::parse(json.out)["details"]["device"]["vendor_errors"] == 3);
}

TEST_CASE("a session lasts until a device ends and ten seconds with the virtual device", "[program]") {
    const TemporaryFolder folder;
    const std::string model = folder.file("law.h5");
    write_model(model, energy_model_example(), {"test", 1, {}});
    const auto ticks = [&](const std::string& arguments) {
        const Ended e = run(folder, model + " --no-clock --json " + arguments);
        REQUIRE(e.status == 0);
        return nlohmann::json::parse(e.out)["ticks"].get<long long>();
    };
    CHECK(ticks("") == 10000);
    const std::string recording = folder.file("twelve.h5");
    CHECK(ticks("--seconds 12 --record " + recording) == 12000);
    CHECK(ticks("--device replay --trajectory " + recording) == 12000);
    CHECK(ticks("--second-device replay --second-trajectory " + recording) == 12000);  // until the first device ends
}

TEST_CASE("tissue-haptic exits with 1 for failed work and 2 for a wrong command line", "[program]") {
    const TemporaryFolder folder;
    const std::string model = model_file(folder);
    const auto ended = [&](const std::string& arguments, int status) {
        const Ended e = run(folder, arguments);
        CHECK(e.status == status);
        return e.err;
    };
    CHECK(ended(folder.file("missing.h5"), 1).find("missing.h5") != std::string::npos);
    CHECK(ended(model + " --device openhaptics --library libHD_none.so", 1).find("cannot load") != std::string::npos);
    CHECK(ended(model + " --device force-dimension --drd-library libdrd_none.so", 1).find("cannot load libdrd_none.so") != std::string::npos);
    CHECK(ended(model + " --device force-dimension --home maybe", 2).find("must be yes or no, not maybe") != std::string::npos);
    CHECK(ended(model + " --device force-dimension --device-id 32", 2).find("must be a number from 0 to 31, not 32") != std::string::npos);
    CHECK(ended(model + " --device openhaptics --home yes", 2).find("is an option of device force-dimension, not of openhaptics") != std::string::npos);
    CHECK(ended(model + " --sets best", 1).find("example, optimum") != std::string::npos);
    CHECK(ended(model + " --record " + folder.file("no/s.h5"), 1).find("cannot write") != std::string::npos);
    CHECK(ended(model + " --device replay --trajectory " + folder.file("none.csv"), 1).find("none.csv") != std::string::npos);
    ended("", 2);
    ended(model + " --device mouse", 2);
    CHECK(ended(model + " --device replay", 2).find("needs --trajectory FILE") != std::string::npos);
    CHECK(ended(model + " --motion stab", 2).find("press, slide, poke, probe, sine") != std::string::npos);
    ended(model + " --depth 0", 2);
    ended(model + " --device remote --port 70000", 2);
    ended(model + " --force-max -1", 2);
    ended(model + " --axes x,x", 2);
    // Options without an effect.
    ended(model + " --trajectory nowhere.csv", 2);
    ended(model + " --device replay --trajectory nowhere.csv --port 5", 2);
    for (const char* option : {" --record r.h5", " --json", " --seconds 1", " --force-max 2", " --hidden h.h5", " --motion poke", " --device replay", " --seed 3", " --no-realtime"}) ended(model + " --check " + model + " --out o.json" + option, 2);
    ended(model + " --check " + model, 2);
    ended(model + " --swiftly", 2);
    CHECK(run(folder, "--version").out.find("tissue-haptic ") == 0);
}

TEST_CASE("tissue-haptic prints its help as a table of option and default and unit and meaning", "[program]") {
    const TemporaryFolder folder;
    const Ended help = run(folder, "--help");
    CHECK(help.status == 0);
    CHECK(help.out.find("option                 default      unit       meaning") != std::string::npos);
    CHECK(help.out.find("--force-max            3.3          N ") != std::string::npos);
}

TEST_CASE("the shipped client drives tissue-haptic over UDP and receives its forces", "[program]") {
    const TemporaryFolder folder;
    const std::string client = (std::filesystem::path(__FILE__).parent_path() / "../../scripts/remote_device.py").string();
    const char* python = std::getenv("PYTHON");
    const int port = 40000 + static_cast<int>(::getpid()) % 20000;
    const std::string arguments = model_file(folder) + " --device remote --port " + std::to_string(port) + " --seconds 0 --json";
    // The program listens once its first messages are printed. It ends after the client.
    const int status = std::system(("sh -c '" + program() + " " + arguments + " > " + folder.file("out") + " 2> " + folder.file("err") +
                                    " & child=$!; " + until_it_runs(folder) +
                                    (python ? python : "python3") + " " + client + " " + std::to_string(port) + " 1.5 > " + folder.file("client") +
                                    "; client=$?; sleep 1; kill -TERM $child; wait $child || exit 3; exit $client'").c_str());
    INFO(read_file(folder.file("err")) << read_file(folder.file("client")));
    REQUIRE(WEXITSTATUS(status) == 0);
    const nlohmann::json j = nlohmann::json::parse(read_file(folder.file("out")));
    // No answer before the first position and at most one per tick, plus one at the end. No more came than was sent.
    const std::string told = read_file(folder.file("client"));
    double client_sent = 0, answers = 0;
    REQUIRE(std::sscanf(told.substr(told.rfind("sent ")).c_str(), "sent %lf, answers %lf", &client_sent, &answers) == 2);
    const nlohmann::json device = j["details"]["device"];
    CHECK(device["sent"].get<double>() <= j["ticks"].get<double>() - device["ticks_before_first"].get<double>() + 1);
    CHECK(device["received"].get<double>() > 1);
    CHECK(device["received"].get<double>() + device["lost"].get<double>() <= client_sent);
    CHECK(answers > 0);
    CHECK(answers <= device["sent"].get<double>());
    CHECK(device["foreign"] == 0);
    CHECK(j["force_max_N"].get<double>() > 1e-4);
    const nlohmann::json& details = j["details"];
    CHECK(details["stale"].get<int>() > 0);  // the client ends before the program
    CHECK(j["bad_input"] == details["not_finite"].get<int>() + details["jumps"].get<int>() + details["stale"].get<int>());
}

TEST_CASE("tissue-haptic is built without assertions that could end it with a device open", "[program]") {
    if (!Allocations::seen()) return;  // a sanitized build has them
    const TemporaryFolder folder;
    REQUIRE(std::system(("nm -D --undefined-only " + program() + " > " + folder.file("symbols")).c_str()) == 0);
    const std::string symbols = read_file(folder.file("symbols"));
    CHECK(symbols.find(" malloc") != std::string::npos);  // the list is that of the program's calls
    CHECK(symbols.find("assert_fail") == std::string::npos);
}

TEST_CASE("tissue-haptic links neither Boost nor Python", "[program]") {
    const TemporaryFolder folder;
    REQUIRE(std::system(("ldd " + program() + " > " + folder.file("libraries")).c_str()) == 0);
    const std::string libraries = read_file(folder.file("libraries"));
    CHECK(libraries.find("boost") == std::string::npos);
    CHECK(libraries.find("python") == std::string::npos);
}

TEST_CASE("the shipped client ignores forged and invalid forces and limits the others", "[program]") {
    const TemporaryFolder folder;
    const std::string client = (std::filesystem::path(__FILE__).parent_path() / "../../scripts/remote_device.py").string();
    const char* python = std::getenv("PYTHON");
    const int socket = ::socket(AF_INET, SOCK_DGRAM, 0), forger = ::socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in here{}, there{};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof here;
    REQUIRE(::bind(socket, reinterpret_cast<sockaddr*>(&here), sizeof here) == 0);
    REQUIRE(::getsockname(socket, reinterpret_cast<sockaddr*>(&here), &length) == 0);
    const timeval wait{60, 0};
    setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait);
    int ended = -1;  // status of the shell
    std::thread runs([&] {
        ended = std::system((std::string(python ? python : "python3") + " " + client + " " + std::to_string(ntohs(here.sin_port)) + " 2 > " + folder.file("out") + " 2> " +
                     folder.file("err") + "; echo $? > " + folder.file("status")).c_str());
    });
    const auto force = [](std::uint32_t used, double x, double y, double z) { return ForceDatagram{{'T', 'S', 'F', '1'}, used, 0, {x, y, z}, 0}; };
    PositionDatagram position{};
    int heard = 0;
    for (; heard < 200; ++heard) {
        length = sizeof there;
        if (::recvfrom(socket, &position, sizeof position, 0, reinterpret_cast<sockaddr*>(&there), &length) != sizeof position) break;
        const auto say = [&](int from, const void* data, std::size_t size) { ::sendto(from, data, size, 0, reinterpret_cast<sockaddr*>(&there), sizeof there); };
        const ForceDatagram forged = force(position.sequence, 1, 0, 0), good = force(position.sequence, 0, 0.25, 0), strong = force(position.sequence, 1000, 0, 0),
                            nan = force(position.sequence, std::nan(""), 0, 0), ahead = force(position.sequence + 1000000, 2, 0, 0);
        say(forger, &forged, sizeof forged);
        say(socket, "x", 1);
        say(socket, "", 0);
        say(socket, &nan, sizeof nan);
        say(socket, &ahead, sizeof ahead);
        say(socket, &good, sizeof good - 1);
        if (heard < 100) say(socket, &good, sizeof good);
        else say(socket, &strong, sizeof strong);
    }
    runs.join();
    ::close(socket);
    ::close(forger);
    const std::string told = read_file(folder.file("out"));
    INFO(told << read_file(folder.file("err")));
    CHECK(heard == 200);
    CHECK(ended == 0);
    CHECK(read_file(folder.file("status")) == "0\n");
    // the other end has fallen silent
    CHECK(told.find("largest force 3.3000 N, at the end 0.0000 N, refused ") != std::string::npos);
    double sent = 0, answers = 0;
    REQUIRE(std::sscanf(told.substr(told.rfind("sent ")).c_str(), "sent %lf, answers %lf", &sent, &answers) == 2);
    CHECK(answers <= 200);  // those of the other socket do not count
    CHECK(answers > 0);
}
