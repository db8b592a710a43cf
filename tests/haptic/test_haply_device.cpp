#include <atomic>
#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "../allocations.h"
#include "../refusal.h"
#include "../wait_for.h"
#include "error.h"
#include "haptic/device_error.h"
#include "haptic/haply_device.h"
#include "haptic/realtime_loop.h"
#include "haptic/running_device.h"
#include "haptic_example.h"

using namespace tissue;
using Catch::Contains;

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;
using Code = beast::error_code;
using Json = nlohmann::json;

double statistics(const Device& device, const std::string& name) {
    for (const auto& [key, value] : device.statistics())
        if (key == name) return value;
    FAIL_CHECK("no entry " << name);
    return 0;
}

/// A stand-in for the Haply Inverse Service with one Inverse3, 049D, and a VerseGrip, as the vendor documents them: the
/// version by HTTP, a list of devices where a WebSocket opens, then one state for each message; and the events.
class Service {
   public:
    Service() {
        state_port = listen(state_), events_port = listen(events_);
        state_thread_ = std::thread([this] { serve_states(); });
        events_thread_ = std::thread([this] { serve_events(); });
    }
    ~Service() {
        ending_ = true;
        stalls = false;
        cut(state_.native_handle()), cut(events_.native_handle());
        cut(state_socket_), cut(events_socket_);
        state_thread_.join(), events_thread_.join();
    }
    Service(const Service&) = delete;
    Service& operator=(const Service&) = delete;

    HaplyDevice::Options options() const {
        HaplyDevice::Options o;
        o.url = "ws://127.0.0.1:" + std::to_string(state_port);
        o.events_port = events_port;
        return o;
    }

    static Json device(const std::string& id, double x = 0.01, double y = -0.12, double z = 0.15) {
        return {{"device_id", id},
                {"state", {{"cursor_position", {{"x", x}, {"y", y}, {"z", z}}}, {"current_cursor_force", Json::object()}, {"control_mode", "force"}}},
                {"status", {{"calibrated", true}, {"in_use", true}, {"power_supply", true}, {"ready", true}, {"started", true}}}};
    }
    static Json configured(Json device, const std::string& type = "inverse3") {
        device["config"] = {{"type", type}, {"filters", {{"force_gate", {{"gain", 0.3}}}, {"damping", {{"scalar", 0.5}}}}}};
        return device;
    }

    /// Answers of all later messages: a state, or any text.
    void answer(const Json& state) { answer_raw(state.dump()); }
    void answer_raw(const std::string& text) {
        const std::lock_guard lock(mutex_);
        answer_ = text;
    }
    /// what every answer is until answer()
    static Json state() { return {{"inverse3", Json::array({device("049D")})}, {"verse_grip", Json::array()}}; }
    static Json state_with(Json position) {
        Json s = state();
        s["inverse3"][0]["state"]["cursor_position"] = std::move(position);
        return s;
    }

    Json last() const {
        const std::lock_guard lock(mutex_);
        return last_;
    }
    /// x of the newest force.
    double force() const {
        const Json message = last();
        return message.is_null() ? 0 : message["inverse3"][0]["commands"]["set_cursor_force"]["vector"]["x"].get<double>();
    }
    Json first() const {
        const std::lock_guard lock(mutex_);
        return first_;
    }
    void tell(const std::string& event) {
        REQUIRE(wait_for([&] { return listened.load(); }));
        Code error;
        listener_->write(asio::buffer(event), error);
        CHECK_FALSE(error);
    }
    void tell(const std::string& name, const std::string& level, const std::string& id) {
        tell(Json({{"name", name}, {"category", "device"}, {"level", level}, {"data", {{"device_family", "inverse"}, {"device_id", id}}}, {"message", ""}}).dump());
    }
    void hang_up() { cut(state_socket_); }
    void end_events() { cut(events_socket_); }

    /// of devices that connect later
    void be_version(const std::string& text) {
        const std::lock_guard lock(mutex_);
        version_ = text;
    }
    void list(const std::string& text) {
        const std::lock_guard lock(mutex_);
        inventory_ = text;
    }

    int state_port = 0, events_port = 0;
    std::atomic<bool> stalls{false}, closed{false}, listened{false};
    std::atomic<int> sessions{0};
    std::atomic<long> messages{0}, answers{0};

   private:
    static void cut(int socket) {
        if (socket >= 0) ::shutdown(socket, SHUT_RDWR);
    }
    int listen(Tcp::acceptor& acceptor) {
        acceptor.open(Tcp::v4());
        acceptor.bind({asio::ip::address_v4::loopback(), 0});
        acceptor.listen();
        return acceptor.local_endpoint().port();
    }

    void serve_states() {
        while (!ending_) {
            Code error;
            Tcp::socket socket(context_);
            state_.accept(socket, error);
            if (error) return;
            socket.set_option(Tcp::no_delay(true), error);
            state_socket_ = socket.native_handle();
            beast::flat_buffer buffer;
            http::request<http::string_body> request;
            http::read(socket, buffer, request, error);
            if (!error && websocket::is_upgrade(request)) play(std::move(socket), request);
            else if (!error) {
                http::response<http::string_body> response{request.target() == "/version" ? http::status::ok : http::status::not_found, 11};
                {
                    const std::lock_guard lock(mutex_);
                    response.body() = version_;
                }
                response.prepare_payload();
                http::write(socket, response, error);
            }
            state_socket_ = -1;
        }
    }

    void play(Tcp::socket socket, const http::request<http::string_body>& request) {
        Code error;
        websocket::stream<Tcp::socket> client(std::move(socket));
        client.accept(request, error);
        const std::string inventory = [&] {
            const std::lock_guard lock(mutex_);
            return inventory_;
        }();
        client.write(asio::buffer(inventory), error);
        ++sessions;
        closed = false;
        while (!error) {
            beast::flat_buffer buffer;
            client.read(buffer, error);
            if (error) break;
            Json message = Json::parse(beast::buffers_to_string(buffer.data()), nullptr, false);
            std::string text;
            {
                const std::lock_guard lock(mutex_);
                if (first_.is_null()) first_ = message;
                last_ = std::move(message);
                text = answer_;
            }
            ++messages;
            while (stalls) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            ++answers;
            client.write(asio::buffer(text), error);
        }
        closed = true;
    }

    void serve_events() {
        while (!ending_) {
            Code error;
            Tcp::socket socket(context_);
            events_.accept(socket, error);
            if (error) return;
            events_socket_ = socket.native_handle();
            listener_ = std::make_unique<websocket::stream<Tcp::socket>>(std::move(socket));
            listener_->accept(error);
            if (error) continue;
            listened = true;
            char byte;
            ::recv(events_socket_, &byte, 1, MSG_PEEK);  // a client has nothing to say but that it goes
            listened = false;
            cut(events_socket_);
        }
    }

    asio::io_context context_;
    Tcp::acceptor state_{context_}, events_{context_};
    std::unique_ptr<websocket::stream<Tcp::socket>> listener_;
    std::atomic<int> state_socket_{-1}, events_socket_{-1};
    std::atomic<bool> ending_{false};
    mutable std::mutex mutex_;
    std::string version_ = R"({"project_name":"haply-inverse-service","project_version":"3.5.0.0"})";
    std::string inventory_ = Json({{"session_id", 7}, {"inverse3", Json::array({configured(device("049D"))})}}).dump();
    std::string answer_ = state().dump();
    Json first_, last_;
    std::thread state_thread_, events_thread_;
};

/// Why a session ended in which the service began to answer `text`.
std::string ends_by(const std::function<void(Service&)>& act) {
    Service service;
    HaplyDevice device(service.options());
    const RunningDevice running(device);
    CHECK(wait_for([&] { return device.read(0).valid; }));
    CHECK(device.failure().empty());
    act(service);
    CHECK(wait_for([&] { return device.finished(); }));
    CHECK_FALSE(device.read(0).valid);
    device.write({1, 0, 0});
    const std::string why = device.failure();
    CHECK(why.find('\n') == std::string::npos);
    device.stop();
    CHECK(device.failure() == why);
    CHECK_FALSE(device.finished());
    return why;
}

std::string refused(const Service& service, HaplyDevice::Options options) {
    HaplyDevice device(std::move(options));
    const std::string why = refusal<DeviceError>([&] { const RunningDevice running(device); });
    CHECK_FALSE(device.read(0).valid);
    CHECK_FALSE(device.finished());
    CHECK(service.messages == 0);  // no force was sent
    return why;
}
std::string refused(const Service& service) { return refused(service, service.options()); }

}  // namespace

TEST_CASE("haply takes positions from states and sends forces in newtons, one message for each answer", "[device][haply]") {
    Service service;
    HaplyDevice device(service.options());
    CHECK_FALSE(device.read(0).valid);
    device.write({1, 0, 0});  // before start(): no force
    device.start();
    CHECK(service.force() == 0);
    CHECK_THAT(service.first()["session"]["configure"]["profile"]["name"].get<std::string>(), Contains("tissuectl"));
    DeviceSample s;
    CHECK(wait_for([&] { return (s = device.read(0)).valid; }));
    CHECK((s.position_m - Eigen::Vector3d(0.01, -0.12, 0.15)).norm() < 1e-12);
    CHECK(wait_for([&] {
        device.write({0.5, 0.25, -1});
        return service.force() == 0.5;
    }));
    const Json message = service.last();
    CHECK(message["inverse3"][0]["device_id"] == "049D");
    CHECK_FALSE(message.contains("session"));  // in the first message alone
    CHECK(message["inverse3"][0]["commands"]["set_cursor_force"]["vector"] == Json({{"x", 0.5}, {"y", 0.25}, {"z", -1.0}}));
    CHECK(service.messages - service.answers <= 1);
    CHECK(statistics(device, "force_gate_gain") == 0.3);
    CHECK(statistics(device, "service_damping") == 0.5);

    // what a state leaves out is 0
    service.answer(Service::state_with({{"y", 0.2}}));
    CHECK(wait_for([&] { return device.read(0).position_m == Eigen::Vector3d(0, 0.2, 0); }));
    service.answer(Service::state_with(Json::object()));
    CHECK(wait_for([&] { return (s = device.read(0)).position_m.isZero(0); }));
    CHECK(s.valid);
    device.stop();
    CHECK(wait_for([&] { return service.closed.load(); }));
    CHECK(service.force() == 0);
    CHECK(statistics(device, "exchanges") == service.answers);
    CHECK(device.failure().empty());
    device.write({1, 0, 0});
    device.start();  // again
    CHECK(wait_for([&] { return device.read(0).valid; }));
    CHECK(service.sessions == 2);
    CHECK(service.force() == 0);
}

TEST_CASE("haply's read and write allocate nothing", "[device][haply]") {
    Service service;
    HaplyDevice device(service.options());
    const RunningDevice running(device);
    CHECK(wait_for([&] { return device.read(0).valid; }));
    const Allocations counted;
    for (int k = 0; k < 1000; ++k) {
        device.read(1e-3 * k);
        device.write({0.1, 0, 0});
        device.finished();
    }
    CHECK(Allocations::count() == 0);
}

TEST_CASE("haply sets a force to zero that is older than half of force_held_s and younger than all of it", "[device][haply]") {
    Service service;
    HaplyDevice device(service.options());
    const RunningDevice running(device);
    using std::chrono::steady_clock;
    bool let_go_in_time = false;  // a busy machine needs several attempts to show it
    for (int k = 0; k < 500 && !let_go_in_time; ++k) {
        const auto from = steady_clock::now();
        device.write({0.5, 0, 0});
        double there_s = 0, now_s = 0;
        do {
            const bool there = service.force() == 0.5;
            now_s = std::chrono::duration<double>(steady_clock::now() - from).count();
            if (there) there_s = now_s;
        } while (now_s < 1.5 * force_held_s);
        let_go_in_time = there_s > force_held_s / 2 && there_s < force_held_s;
    }
    CHECK(let_go_in_time);
    CHECK(statistics(device, "cut_off_forces") > 0);
    CHECK(wait_for([&] { return service.force() == 0; }));
    device.write({std::nan(""), 0, 0});
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    CHECK(service.force() == 0);
}

TEST_CASE("a position of haply has the age of its message and grows old while the service stalls", "[device][haply]") {
    Service service;
    HaplyDevice device(service.options());
    const RunningDevice running(device);
    double youngest_s = 1;
    for (int k = 0; k < 50; ++k) {
        youngest_s = std::min(youngest_s, device.read(0).age_s);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    CHECK(youngest_s < 0.01);
    service.stalls = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const DeviceSample old = device.read(0);
    CHECK(old.age_s > 0.08);
    service.stalls = false;  // shorter than half a second: the exchange goes on
    CHECK(wait_for([&] { return device.read(0).age_s < 0.05; }));
    CHECK(device.read(0).valid);
    CHECK(statistics(device, "late_exchanges") > 0);
    CHECK(statistics(device, "exchange_max_us") > 8e4);
}

TEST_CASE("haply ends with a reason where the service stalls or closes or answers anything that is no state", "[device][haply]") {
    CHECK_THAT(ends_by([](Service& s) { s.stalls = true; }), Contains("has not answered for 500 ms"));
    CHECK_THAT(ends_by([](Service& s) { s.hang_up(); }), Contains("the connection to the service was lost"));
    for (const char* text : {"", "{", "[]", "7", "null", "\"inverse3\"", "{\"inverse3\":[}", "{\"x\":NaN}", "{\"x\":1e999}"})
        CHECK_THAT(ends_by([&](Service& s) { s.answer_raw(text); }), Contains("not a JSON object"));
    CHECK_THAT(ends_by([](Service& s) { s.answer_raw(std::string(200000, '[')); }), Contains("not a JSON object"));
    CHECK_THAT(ends_by([](Service& s) { s.answer_raw("\xff\xfe{}"); }), Contains("the connection to the service was lost"));  // no UTF-8
    CHECK_THAT(ends_by([](Service& s) { s.answer_raw(std::string(300000, ' ')); }), Contains("more than 256 KiB"));
    for (const char* text : {"{}", R"({"inverse3":{}})", R"({"inverse3":[]})", R"({"inverse3":[{}]})", R"({"inverse3":[7,null,[]]})", R"({"inverse3":[{"device_id":49}]})"})
        CHECK_THAT(ends_by([&](Service& s) { s.answer_raw(text); }), Contains("device 049D is no longer among"));
    CHECK_THAT(ends_by([](Service& s) { s.answer({{"inverse3", Json::array({Service::device("04BA")})}}); }), Contains("device 049D is no longer among"));  // another id
    for (const char* state : {"{}", "7", "[]", R"({"cursor_position":7})", R"({"cursor_position":[0,0,0]})"})
        CHECK_THAT(ends_by([&](Service& s) { s.answer_raw(R"({"inverse3":[{"device_id":"049D","state":)" + std::string(state) + "}]}"); }), Contains("without its position"));
    for (const Json& x : {Json("0.1"), Json(true), Json::array(), Json(1e300), Json(-11)})
        CHECK_THAT(ends_by([&](Service& s) { s.answer(Service::state_with({{"z", x}})); }), Contains("no number or beyond 10 m"));
}

TEST_CASE("haply's last force is zero where the service fails but can still be reached", "[device][haply]") {
    Service service;
    HaplyDevice device(service.options());
    const RunningDevice running(device);
    CHECK(wait_for([&] {
        device.write({0.5, 0, 0});
        return service.force() == 0.5;
    }));
    service.answer({{"inverse3", Json::array()}});
    for (int k = 0; k < 10; ++k) device.write({0.5, 0, 0});
    CHECK(wait_for([&] { return service.closed.load(); }));
    CHECK(service.force() == 0);
}

TEST_CASE("haply stops soon while the service stalls", "[device][haply]") {
    Service service;
    HaplyDevice device(service.options());
    device.start();
    service.stalls = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const auto from = std::chrono::steady_clock::now();
    device.stop();
    CHECK(std::chrono::steady_clock::now() - from < std::chrono::seconds(5));
    CHECK(device.failure().empty());
}

TEST_CASE("haply refuses a service that is absent or old or unknown", "[device][haply]") {
    Service service;
    const auto of_version = [&](const std::string& text) {
        service.be_version(text);
        return refused(service);
    };
    CHECK_THAT(of_version(R"({"project_version":"3.4.9.0"})"), Contains("has version 3.4, and this program needs 3.5 or a later 3.x: update it"));
    CHECK_THAT(of_version(R"({"project_version":"2.9"})"), Contains("has version 2.9"));
    CHECK_THAT(of_version(R"({"project_version":"4.0.0.0"})"), Contains("install one of those"));
    for (const char* text : {"", "{}", "[]", "<html>", R"({"project_version":3.5})", R"({"project_version":"new"})", R"({"project_version":"3"})", R"({"project_version":"3."})", R"({"data":7})"})
        CHECK_THAT(of_version(text), Contains("does not say its version"));
    CHECK_THAT(of_version(std::string(100000, ' ')), Contains("the request for the version was not answered"));
    service.be_version(R"({"ok":true,"data":{"project_version":"3.12.1.0"}})");  // in an envelope
    HaplyDevice device(service.options());
    device.start();
    device.stop();

    HaplyDevice::Options nobody = service.options();
    {
        asio::io_context context;
        const Tcp::acceptor taken(context, {asio::ip::address_v4::loopback(), 0}, false);
        nobody.url = "ws://localhost:" + std::to_string(taken.local_endpoint().port());
    }
    const std::string why = refusal<DeviceError>([&] { HaplyDevice(nobody).start(); });
    CHECK_THAT(why, Contains("cannot connect: Connection refused at ws://localhost:"));
    CHECK_THAT(why, Contains("start the Haply Inverse Service"));
    nobody = service.options();
    nobody.events_port = 1;
    CHECK_THAT(refusal<DeviceError>([&] { HaplyDevice(nobody).start(); }), Contains("cannot connect to port 1"));
    nobody.events_port = 0;
    HaplyDevice deaf(nobody);
    deaf.start();
    CHECK(statistics(deaf, "events_heard") == 0);
}

TEST_CASE("haply chooses the only device or the one that is named", "[device][haply]") {
    Service service;
    const auto of_inventory = [&](const std::string& text) {
        service.list(text);
        return refused(service);
    };
    const auto of_devices = [&](const Json& devices) { return of_inventory(Json({{"inverse3", devices}}).dump()); };
    CHECK_THAT(of_inventory("]"), Contains("is not a JSON object"));
    CHECK_THAT(of_inventory("{}"), Contains("has no Inverse3 or Minverse"));
    CHECK_THAT(of_devices(Json::array()), Contains("has no Inverse3 or Minverse"));
    CHECK_THAT(of_devices(Json::array({{{"device_id", "a\"b"}}})), Contains("other characters than letters"));
    CHECK_THAT(of_devices(Json::array({7})), Contains("other characters than letters"));
    CHECK_THAT(of_devices(Json::array({Service::configured(Service::device("049D"), "wireless_verse_grip")})), Contains("is wireless_verse_grip, and no Inverse3"));
    CHECK_THAT(of_devices(Json::array({Service::configured(Service::device("049D"), "\n")})), Contains("of an unknown kind"));
    Json idle = Service::configured(Service::device("049D"));
    idle["status"]["calibrated"] = false;
    CHECK_THAT(of_devices(Json::array({idle})), Contains("is not calibrated"));
    idle["status"] = {{"power_supply", false}};
    CHECK_THAT(of_devices(Json::array({idle})), Contains("no power"));
    const Json two = Json::array({Service::configured(Service::device("04BA")), Service::configured(Service::device("049D"), "minverse")});
    CHECK_THAT(of_devices(two), Contains("several devices, 04BA, 049D: choose one by --haply-device-id"));
    HaplyDevice::Options named = service.options();
    named.device_id = "049E";
    CHECK_THAT(refused(service, named), Contains("no device '049E', but 04BA, 049D"));
    CHECK_THAT(of_inventory(std::string(300000, ' ')), Contains("no list of devices came"));

    service.list(Json({{"inverse3", two}}).dump());
    service.answer({{"inverse3", Json::array({Service::device("04BA", 0.3), Service::device("049D", 0.2)})}});
    named.device_id = "049D";
    HaplyDevice device(named);
    const RunningDevice running(device);
    CHECK(device.read(0).position_m.x() == 0.2);
    CHECK(service.last()["inverse3"][0]["device_id"] == "049D");
    CHECK(statistics(device, "force_gate_gain") == 0.3);
}

TEST_CASE("haply's positions are not valid while the device is not calibrated, and filters that are not told are NaN", "[device][haply]") {
    Service service;
    service.list(Json({{"inverse3", Json::array({Service::device("049D")})}}).dump());
    HaplyDevice device(service.options());
    const RunningDevice running(device);
    CHECK(std::isnan(statistics(device, "force_gate_gain")));
    CHECK(std::isnan(statistics(device, "service_damping")));
    for (const char* name : {"calibrated", "ready"}) {
        Json state = Service::state();
        state["inverse3"][0]["status"][name] = false;
        service.answer(state);
        CHECK(wait_for([&] { return !device.read(0).valid; }));
        CHECK_FALSE(device.finished());
        service.answer(Service::state());
        CHECK(wait_for([&] { return device.read(0).valid; }));
    }
    CHECK(statistics(device, "not_ready") > 0);
    Json bare = Service::state();
    bare["inverse3"][0].erase("status");
    bare["inverse3"][0]["state"]["cursor_position"]["x"] = 0.02;
    service.answer(bare);
    CHECK(wait_for([&] { return device.read(0).position_m.x() == 0.02; }));
    CHECK(device.read(0).valid);
}

TEST_CASE("the button of any grip grasps, or that of the named one", "[device][haply]") {
    const auto with = [](const char* family, const char* id, const Json& of_grip) {
        Json state = Service::state();
        state[family] = Json::array({{{"device_id", id}, {"state", of_grip}}});
        return state;
    };
    Service service;
    HaplyDevice::Options named = service.options();
    named.grip_id = "61548";
    for (const HaplyDevice::Options& options : {service.options(), named}) {
        HaplyDevice device(options);
        const RunningDevice running(device);
        const Json a = {{"buttons", {{"a", true}}}};
        for (const Json& down : {with("verse_grip", "61548", {{"button", true}}), with("wireless_verse_grip", "61548", a), with("custom_verse_grip", "61548", a)}) {
            service.answer(down);
            CHECK(wait_for([&] { return device.read(0).grasp; }));
            service.answer(with("verse_grip", "61548", {{"button", false}}));
            CHECK(wait_for([&] { return !device.read(0).grasp; }));
        }
        service.answer(with("verse_grip", "99", {{"button", true}}));  // another grip
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        CHECK(device.read(0).grasp == options.grip_id.empty());
        for (const Json& up : {Json({{"button", "yes"}}), Json({{"button", 1}}), Json({{"buttons", {{"b", true}}}}), Json({{"buttons", true}}), Json(7)}) {
            service.answer(with("verse_grip", "61548", up));
            CHECK(wait_for([&] { return !device.read(0).grasp; }));
            CHECK(device.read(0).valid);
        }
        service.answer(Service::state());
    }
}

TEST_CASE("events of the service stand in haply's statistics, and a disconnected device ends the session", "[device][haply]") {
    Service service;
    HaplyDevice device(service.options());
    const RunningDevice running(device);
    CHECK(statistics(device, "events_heard") == 1);
    service.tell("device-safety-triggered", "error", "049D");
    service.tell("device-safety-triggered", "notice", "04BA");  // of another device
    service.tell("device-disconnected", "warning", "04BA");
    for (const char* text : {"", "{", "[]", R"({"name":7})"}) service.tell(text);
    CHECK(wait_for([&] { return statistics(device, "events") == 3 && statistics(device, "foreign_events") == 4; }));
    CHECK(statistics(device, "safety_events") == 1);
    CHECK(statistics(device, "error_events") == 1);
    CHECK(statistics(device, "disconnections") == 0);
    CHECK_FALSE(device.finished());
    service.tell("device-disconnected", "warning", "049D");  // the service goes on with states
    CHECK(wait_for([&] { return device.finished(); }));
    CHECK_THAT(device.failure(), Contains("device 049D was disconnected"));
    CHECK_FALSE(device.read(0).valid);
    CHECK(statistics(device, "disconnections") == 1);
    CHECK(wait_for([&] { return service.closed.load(); }));
    CHECK(service.force() == 0);
}

TEST_CASE("haply goes on without events where their connection ends or one is too long", "[device][haply]") {
    const std::string long_event(100000, ' ');
    for (const std::string& text : {std::string(), long_event}) {
        Service service;
        HaplyDevice device(service.options());
        const RunningDevice running(device);
        CHECK(statistics(device, "events_heard") == 1);
        if (text.empty()) service.end_events();
        else service.tell(text);
        CHECK(wait_for([&] { return statistics(device, "events_heard") == 0; }));
        const double before = statistics(device, "exchanges");
        CHECK(wait_for([&] { return statistics(device, "exchanges") > before + 10; }));
        CHECK(device.read(0).valid);
    }
}

TEST_CASE("a whole session on haply's stand-in renders a force, and ends with zero force when the device goes", "[device][haply]") {
    Service service;
    HapticOptions o;
    o.map.force_scale = 100;
    const HapticModel model(haptic_example(), o);
    Simulation simulation(model);
    HaplyDevice device(service.options());
    std::atomic<double> largest{0};
    service.answer(Service::state_with({{"x", 0.05}, {"y", 0.105}}));
    std::thread hand([&] {  // presses the block from above, and is unplugged
        for (int k = 0; k < 300 || (largest <= 0.05 && k < 20000); ++k) {
            service.answer(Service::state_with({{"x", 0.05}, {"y", 0.105 - 0.00005 * std::min(k, 299)}}));
            const Json message = service.last();
            if (!message.is_null()) largest = std::max(largest.load(), message["inverse3"][0]["commands"]["set_cursor_force"]["vector"]["y"].get<double>());
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        service.answer({{"inverse3", Json::array()}});
    });
    LoopOptions loop;
    loop.seconds = 0;
    loop.realtime = false;
    const LoopReport report = run_loop(simulation, device, loop);
    hand.join();
    CHECK(report.ticks > 10);
    CHECK(largest > 0.05);
    CHECK_THAT(device.failure(), Contains("device 049D is no longer among"));
    CHECK(service.last()["inverse3"][0]["commands"]["set_cursor_force"]["vector"] == Json({{"x", 0.0}, {"y", 0.0}, {"z", 0.0}}));
}

TEST_CASE("what is known of haply's devices limits a session: the stiffest stable contact and the largest force", "[device][haply]") {
    CHECK(HaplyDevice::kind.impedance.force_max_N <= 3);
    // no more than half of what a Touch, whose mass is known, may render by its mass and delay
    CHECK(stable_stiffness_N_m(haply_impedance, 1e-3, 1) < 0.5 * stable_stiffness_N_m(touch_impedance, 1e-3, 1));
    DeviceImpedance said;
    said.force_max_N = 10;
    CHECK(stricter(said, haply_impedance).force_max_N == haply_impedance.force_max_N);
}
