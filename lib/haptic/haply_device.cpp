#include "haptic/haply_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <charconv>
#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "haptic/device_error.h"
#include "version.h"

namespace tissue {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Code = beast::error_code;
using Clock = std::chrono::steady_clock;
using Json = nlohmann::json;
using Socket = websocket::stream<beast::tcp_stream>;

constexpr auto step_time = std::chrono::seconds(5);            // for each step of a start
constexpr auto silent_time = std::chrono::milliseconds(500);   // without an answer: the service has stalled
constexpr auto farewell_time = std::chrono::milliseconds(500); // for the last force and the end of the connection
constexpr auto watch_time = std::chrono::milliseconds(20);
constexpr std::size_t frame_max = 256 * 1024;                  // the states of some twenty devices take a tenth
constexpr std::size_t event_max = 64 * 1024, version_max = 64 * 1024;
constexpr double reach_max_m = 10;                             // the devices reach 0.3 m; the service may scale positions
constexpr auto let_go_ns = static_cast<long long>(0.75e9 * force_held_s);
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

long long now_ns() noexcept {
    return Clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

std::optional<int> whole_number(const std::string& text, int high) {
    int value = 0;
    const char* end = text.data() + text.size();
    const auto [at, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || at != end || value < 0 || value > high) return std::nullopt;
    return value;
}

struct Place {
    std::string host;  ///< as requests name it
    asio::ip::tcp::endpoint endpoint;
};

/// The place that a URL names, if it is on this machine. No name is resolved: localhost is 127.0.0.1.
std::optional<Place> place_of(const std::string& url) {
    constexpr std::pair<const char*, const char*> hosts[] = {{"localhost", "127.0.0.1"}, {"127.0.0.1", "127.0.0.1"}, {"[::1]", "::1"}};
    std::string rest = url;
    if (rest.rfind("ws://", 0) != 0) return std::nullopt;
    rest.erase(0, 5);
    if (!rest.empty() && rest.back() == '/') rest.pop_back();
    for (const auto& [host, address] : hosts) {
        const std::string name = host;
        if (rest.rfind(name, 0) != 0) continue;
        const std::string port = rest.substr(name.size());
        const std::optional<int> number = port.empty() ? 10001 : port[0] == ':' ? whole_number(port.substr(1), 65535) : std::nullopt;
        if (!number || *number == 0) return std::nullopt;
        return Place{fmt::format("{}:{}", name, *number), {asio::ip::make_address(address), static_cast<unsigned short>(*number)}};
    }
    return std::nullopt;
}

std::string wrong_url(const std::string& url) {
    return place_of(url) ? "" : "must be ws://HOST or ws://HOST:PORT of this machine, where HOST is localhost, 127.0.0.1 or [::1], not " + url;
}

std::string wrong_port(const std::string& text) {
    return whole_number(text, 65535) ? "" : "must be a number from 0 to 65535, not " + text;
}

/// True for an id that a message, a line for a person and an option can contain as it is.
bool is_plain(const std::string& id) {
    return !id.empty() && id.size() <= 64 &&
           std::all_of(id.begin(), id.end(), [](char c) { return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '-' || c == '_'; });
}

// ---- JSON of the service: anything may be missing or of another type, and nothing throws

const Json nothing;

/// A member of an object; null where there is none.
const Json& member(const Json& in, const char* name) {
    if (!in.is_object()) return nothing;
    const auto at = in.find(name);
    return at == in.end() ? nothing : *at;
}

std::string text_of(const Json& in) {
    const auto* text = in.get_ptr<const std::string*>();
    return text ? *text : std::string();
}

bool is_true(const Json& in) {
    return in.is_boolean() && in.get<bool>();
}

bool is_false(const Json& in) {
    return in.is_boolean() && !in.get<bool>();
}

/// A number. 0 where it was left out, NaN where it is none.
double number(const Json& in) {
    return in.is_null() ? 0 : in.is_number() ? in.get<double>() : unknown;
}

/// A gain of the filters; NaN where the service did not say.
double gain(const Json& filter, const char* name) {
    return filter.is_object() ? number(member(filter, name)) : unknown;
}

Json parsed(const beast::flat_buffer& buffer) {
    const auto* text = static_cast<const char*>(buffer.data().data());
    return Json::parse(text, text + buffer.size(), nullptr, false);
}

/// The version as {major, minor}, from "3.5.0.0".
std::optional<std::pair<int, int>> version_in(const std::string& text) {
    std::pair<int, int> version;
    const char* end = text.data() + text.size();
    const auto [dot, bad] = std::from_chars(text.data(), end, version.first);
    if (bad != std::errc() || dot == end || *dot != '.') return std::nullopt;
    if (std::from_chars(dot + 1, end, version.second).ec != std::errc()) return std::nullopt;
    return version;
}

}  // namespace

const DeviceKind HaplyDevice::kind = {
    "haply",
    {{"haply-url", "URL", "ws://localhost:10001", "for haply: the Haply Inverse Service, on this machine only", false, wrong_url},
     {"haply-events-port", "number", "10020", "for haply: the service's port of events; 0: without events", false, wrong_port},
     {"haply-device-id", "NAME", "", "for haply: which device, where the service has several"},
     {"haply-grip-id", "NAME", "", "for haply: the VerseGrip whose button grasps, if not any"}},
    [](const DeviceValues& v, const DeviceContext&) -> std::unique_ptr<Device> {
        return std::make_unique<HaplyDevice>(Options{v.at("haply-url"), std::stoi(v.at("haply-events-port")), v.at("haply-device-id"), v.at("haply-grip-id")});
    },
    haply_impedance};

/// The connections of one session. start() calls open(), and then the thread alone uses this object, in run().
class HaplyDevice::Link {
   public:
    explicit Link(HaplyDevice& device) : device_(device), place_(*place_of(device.options_.url)) {
        message_.reserve(512);
    }

    void open() {
        check_version();
        connect(state_, place_, frame_max);
        complete("no list of devices came", [&](auto done) { state_.async_read(buffer_, done); });
        choose(parsed(buffer_));
        buffer_.clear();
        if (device_.options_.events_port > 0) {
            Place events = place_;
            events.endpoint.port(static_cast<unsigned short>(device_.options_.events_port));
            events.host = fmt::format("{}:{}", place_.host.substr(0, place_.host.rfind(':')), device_.options_.events_port);
            connect(events_, events, event_max);
            device_.counts_.events_heard = true;
        }
        // the first message names this program, so that Haply Hub can show it; later ones need not
        compose(Eigen::Vector3d::Zero(), fmt::format(R"("session":{{"configure":{{"profile":{{"name":"tissuectl:{}"}}}}}},)", tissue::version));
        asked_ns_ = now_ns();
        complete("the first force was not taken", [&](auto done) { state_.async_write(asio::buffer(message_), done); });
        complete("the first force was not answered", [&](auto done) { state_.async_read(buffer_, done); });
        const std::string why = take();
        if (!why.empty()) throw DeviceError(why);
    }

    void run() noexcept {
        try {
            io_.restart();
            watch();
            if (device_.counts_.events_heard) listen();
            ask();
            io_.run();
        } catch (...) {  // no memory
            // this text is so short that it needs none
            if (device_.alive_.load(std::memory_order_relaxed)) device_.failure_ = "out of memory";
            device_.alive_.store(false, std::memory_order_release);
        }
    }

   private:
    // ---- start

    /// Runs one asynchronous step to its end. Throws DeviceError where it fails or takes longer than step_time.
    template <class Begin>
    void complete(const std::string& failed, Begin begin) {
        Code result;
        bool done = false;
        begin([&](Code error, auto...) {
            result = error;
            done = true;
        });
        const auto until = Clock::now() + step_time;
        const auto step = [&] {
            io_.restart();
            io_.run_one_until(until);
        };
        while (!done && Clock::now() < until) step();
        if (!done) {
            close_all();
            while (!done) {  // a closed socket ends its operation
                io_.restart();
                io_.run_one();
            }
            result = beast::error::timeout;
        }
        if (result) throw DeviceError(fmt::format("haply: {}: {} at {}", failed, result.message(), device_.options_.url));
    }

    void check_version() {
        const std::string& url = device_.options_.url;
        try {
            complete("cannot connect", [&](auto done) { http_.async_connect(place_.endpoint, done); });
        } catch (const DeviceError& e) {
            throw DeviceError(std::string(e.what()) + "; start the Haply Inverse Service (it runs while Haply Hub is open), or give its address by --haply-url");
        }
        http::request<http::empty_body> request{http::verb::get, "/version", 11};
        request.set(http::field::host, place_.host);
        request.set(http::field::connection, "close");
        complete("the request for the version was not taken", [&](auto done) { http::async_write(http_, request, done); });
        // a body of bounded size: body_limit() of Boost 1.74 lets one of a given length pass
        http::response_parser<http::basic_dynamic_body<beast::flat_buffer>> answer;
        answer.get().body() = beast::flat_buffer(version_max);
        beast::flat_buffer buffer(version_max);
        complete("the request for the version was not answered", [&](auto done) { http::async_read(http_, buffer, answer, done); });
        http_.close();
        const Json json = parsed(answer.get().body());
        const std::string inside = text_of(member(member(json, "data"), "project_version"));  // in an envelope
        const auto found = version_in(inside.empty() ? text_of(member(json, "project_version")) : inside);
        if (!found) throw DeviceError(fmt::format("haply: what answers at {} is not the Haply Inverse Service: it does not say its version", url));
        const auto [major, minor] = *found;
        if (major != 3 || minor < 5)
            throw DeviceError(fmt::format("haply: the Haply Inverse Service at {} has version {}.{}, and this program needs 3.5 or a later 3.x: {}", url, major, minor,
                                          major > 3 ? "install one of those" : "update it"));
    }

    void connect(Socket& socket, const Place& place, std::size_t longest) {
        complete(fmt::format("cannot connect to port {}", place.endpoint.port()), [&](auto done) { socket.next_layer().async_connect(place.endpoint, done); });
        Code ignored;
        socket.next_layer().socket().set_option(asio::ip::tcp::no_delay(true), ignored);
        socket.read_message_max(longest);
        socket.text(true);
        websocket::stream_base::timeout times{websocket::stream_base::none(), websocket::stream_base::none(), false};
        times.handshake_timeout = step_time;  // also for the end of a connection that broke the rules
        socket.set_option(times);
        complete(fmt::format("port {} refuses a WebSocket", place.endpoint.port()), [&](auto done) { socket.async_handshake(place.host, "/", done); });
    }

    /// Chooses the device from the service's first message, which alone has the configuration.
    void choose(const Json& inventory) {
        const std::string& url = device_.options_.url;
        if (!inventory.is_object()) throw DeviceError(fmt::format("haply: the list of devices from {} is not a JSON object", url));
        const std::string& wanted = device_.options_.device_id;
        std::string ids;
        const Json* chosen = nullptr;
        int count = 0;
        const Json& devices = member(inventory, "inverse3");  // Inverse3x and Minverse are there too
        if (devices.is_array())
            for (const Json& device : devices) {
                const std::string id = text_of(member(device, "device_id"));
                if (!is_plain(id)) throw DeviceError(fmt::format("haply: {} names a device by other characters than letters, digits, - and _", url));
                ids += (ids.empty() ? "" : ", ") + id;
                ++count;
                if (wanted.empty() || id == wanted) chosen = &device;
            }
        if (count == 0) throw DeviceError(fmt::format("haply: the service at {} has no Inverse3 or Minverse: connect one", url));
        if (!chosen) throw DeviceError(fmt::format("haply: the service at {} has no device '{}', but {}", url, wanted, ids));
        if (wanted.empty() && count > 1) throw DeviceError(fmt::format("haply: the service at {} has several devices, {}: choose one by --haply-device-id", url, ids));
        id_ = text_of(member(*chosen, "device_id"));
        const Json& config = member(*chosen, "config");
        const Json& type = member(config, "type");
        const std::string model = text_of(type);
        if (!type.is_null() && model != "inverse3" && model != "inverse3x" && model != "minverse")
            throw DeviceError(fmt::format("haply: device {} is {}, and no Inverse3 or Minverse", id_, is_plain(model) ? model : "of an unknown kind"));
        const Json& status = member(*chosen, "status");
        if (is_false(member(status, "calibrated"))) throw DeviceError(fmt::format("haply: device {} is not calibrated: calibrate it and start again", id_));
        if (is_false(member(status, "power_supply"))) throw DeviceError(fmt::format("haply: device {} has no power for its motors: connect its power supply", id_));
        const Json& filters = member(config, "filters");
        device_.counts_.gate = gain(member(filters, "force_gate"), "gain");
        device_.counts_.damping = gain(member(filters, "damping"), "scalar");
    }

    // ---- exchange

    /// session: what precedes the devices in the message.
    void compose(const Eigen::Vector3d& force_N, const std::string& session = "") {
        message_.clear();
        fmt::format_to(std::back_inserter(message_), R"({{{}"inverse3":[{{"device_id":"{}","commands":{{"set_cursor_force":{{"vector":{{"x":{:.6f},"y":{:.6f},"z":{:.6f}}}}}}}}}]}})",
                       session, id_, force_N.x(), force_N.y(), force_N.z());
    }

    /// The newest force of the tick; zero where that is too old, of an earlier session or no number.
    Eigen::Vector3d current_force() {
        device_.force_.fetch();
        const Written& written = device_.force_.front();
        if (written.at_ns >= began_ns_ && now_ns() - written.at_ns <= let_go_ns && written.force_N.allFinite()) return written.force_N;
        device_.counts_.cut_off.fetch_add(1, std::memory_order_relaxed);
        return Eigen::Vector3d::Zero();
    }

    void ask() {
        last_ = device_.stopping_.load(std::memory_order_acquire);
        compose(last_ ? Eigen::Vector3d::Zero() : current_force());
        asked_ns_ = now_ns();
        writing_ = true;
        state_.async_write(asio::buffer(message_), [this](Code error, std::size_t) {
            writing_ = false;
            if (closing_) {
                if (polite_) let_go();
                return;
            }
            if (error) return end(lost(error), false);
            state_.async_read(buffer_, [this](Code e, std::size_t) { answered(e); });
        });
    }

    void answered(Code error) {
        if (closing_) return;
        if (error) return end(lost(error), false);
        const std::string why = take();
        if (!why.empty()) return end(why, true);
        if (!last_) return ask();
        closing_ = true;
        closing_since_ = Clock::now();
        close();
    }

    std::string lost(Code error) const {
        if (error == websocket::error::message_too_big) return fmt::format("haply: the service sent a frame of more than {} KiB", frame_max / 1024);
        return fmt::format("haply: the connection to the service was lost: {}", error.message());
    }

    /// Takes a state from the answer in the buffer, and empties it. Returns why it cannot be used, "" if it was.
    std::string take() {
        const long long took_ns = now_ns() - asked_ns_;
        const Json frame = parsed(buffer_);
        buffer_.clear();
        Counts& counts = device_.counts_;
        counts.exchanges.fetch_add(1, std::memory_order_relaxed);
        counts.exchanges_ns.fetch_add(took_ns, std::memory_order_relaxed);
        if (took_ns > counts.longest_ns.load(std::memory_order_relaxed)) counts.longest_ns.store(took_ns, std::memory_order_relaxed);
        if (static_cast<double>(took_ns) > 1e9 * haply_impedance.delay_s) counts.late.fetch_add(1, std::memory_order_relaxed);

        if (!frame.is_object()) return "haply: the service sent a state that is not a JSON object";
        const Json* ours = nullptr;
        const Json& devices = member(frame, "inverse3");
        if (devices.is_array())
            for (const Json& device : devices)
                if (text_of(member(device, "device_id")) == id_) ours = &device;
        if (!ours) return fmt::format("haply: device {} is no longer among those of the service", id_);
        // a vector that is zero has its place, and no components
        const Json& position = member(member(*ours, "state"), "cursor_position");
        if (!position.is_object()) return fmt::format("haply: the service sent a state of device {} without its position", id_);
        Measured& m = device_.measured_.back();
        m.position_m = {number(member(position, "x")), number(member(position, "y")), number(member(position, "z"))};
        if (!m.position_m.allFinite() || m.position_m.cwiseAbs().maxCoeff() > reach_max_m)
            return fmt::format("haply: the service sent a position of device {} that is no number or beyond {:g} m", id_, reach_max_m);
        const Json& status = member(*ours, "status");
        m.ready = !is_false(member(status, "calibrated")) && !is_false(member(status, "ready"));
        if (!m.ready) counts.not_ready.fetch_add(1, std::memory_order_relaxed);
        m.grasp = grasps(frame);
        m.asked_ns = asked_ns_;
        device_.measured_.publish();
        return "";
    }

    /// True while a button of a grip is down: state.button of a VerseGrip, state.buttons.a of a wireless or custom one.
    bool grasps(const Json& frame) const {
        for (const char* family : {"verse_grip", "wireless_verse_grip", "custom_verse_grip"}) {
            const Json& grips = member(frame, family);
            if (!grips.is_array()) continue;
            for (const Json& grip : grips) {
                const std::string& wanted = device_.options_.grip_id;
                if (!wanted.empty() && text_of(member(grip, "device_id")) != wanted) continue;
                const Json& state = member(grip, "state");
                if (is_true(member(state, "button")) || is_true(member(member(state, "buttons"), "a"))) return true;
            }
        }
        return false;
    }

    // ---- events

    void listen() {
        events_.async_read(heard_, [this](Code error, std::size_t) {
            if (closing_) return;
            if (error) {  // the exchange goes on without events
                device_.counts_.events_heard = false;
                return;
            }
            const Json event = parsed(heard_);
            heard_.clear();
            hear(event);
            if (!closing_) listen();
        });
    }

    void hear(const Json& event) {
        Counts& counts = device_.counts_;
        const std::string name = text_of(member(event, "name")), level = text_of(member(event, "level"));
        if (name.empty()) {
            counts.foreign.fetch_add(1, std::memory_order_relaxed);
            return;
        }
        counts.events.fetch_add(1, std::memory_order_relaxed);
        if (level == "error" || level == "critical" || level == "panic") counts.errors.fetch_add(1, std::memory_order_relaxed);
        if (text_of(member(member(event, "data"), "device_id")) != id_) return;
        if (name == "device-safety-triggered") counts.safety.fetch_add(1, std::memory_order_relaxed);
        if (name != "device-disconnected") return;
        counts.disconnected.fetch_add(1, std::memory_order_relaxed);
        // states may go on with the last position
        end(fmt::format("haply: the service says that device {} was disconnected", id_), true);
    }

    // ---- end

    /// Ends the exchange because of a failure. polite: with a last zero force, if the connection can take one.
    void end(const std::string& why, bool polite) {
        if (closing_) return;
        closing_ = true;
        closing_since_ = Clock::now();
        device_.failure_ = why;
        device_.alive_.store(false, std::memory_order_release);
        polite_ = polite;
        if (!polite) return close_all();
        if (!writing_) let_go();
    }

    /// Sends a last zero force and closes.
    void let_go() {
        compose(Eigen::Vector3d::Zero());
        state_.async_write(asio::buffer(message_), [this](Code error, std::size_t) {
            if (error) return close_all();
            close();
        });
    }

    void close() {
        state_.async_close(websocket::close_code::normal, [this](Code) { close_all(); });
    }

    /// Closes all connections at once. No operation is left then, and run() returns.
    void close_all() {
        for (beast::tcp_stream* stream : {&http_, &state_.next_layer(), &events_.next_layer()}) stream->close();
        watch_.cancel();
    }

    /// Ends an exchange without an answer, and an end that takes too long.
    void watch() {
        watch_.expires_after(watch_time);
        watch_.async_wait([this](Code error) {
            if (error) return;
            if (closing_) {
                if (Clock::now() - closing_since_ > farewell_time) return close_all();
            } else {
                const std::chrono::nanoseconds silent(now_ns() - asked_ns_);
                const bool stopping = device_.stopping_.load(std::memory_order_acquire);
                if (stopping && silent > farewell_time) {
                    closing_ = true;
                    return close_all();
                }
                if (silent > silent_time) return end(fmt::format("haply: the service has not answered for {} ms", silent_time / std::chrono::milliseconds(1)), false);
            }
            watch();
        });
    }

    HaplyDevice& device_;
    const Place place_;
    asio::io_context io_{1};
    beast::tcp_stream http_{io_};
    Socket state_{io_}, events_{io_};
    asio::steady_timer watch_{io_};
    beast::flat_buffer buffer_, heard_;
    std::string id_, message_;
    const long long began_ns_ = now_ns();
    long long asked_ns_ = 0;
    bool last_ = false;     ///< the message on its way is the last, by stop()
    bool writing_ = false;
    bool polite_ = false;   ///< after a failure: a last zero force goes out, once nothing is being written
    bool closing_ = false;  ///< no exchange begins any more
    Clock::time_point closing_since_;
};

HaplyDevice::HaplyDevice(Options options) : options_(std::move(options)) {
    const std::string wrong = wrong_url(options_.url);
    if (!wrong.empty()) throw MismatchError("haply-url " + wrong);
    if (options_.events_port < 0 || options_.events_port > 65535) throw MismatchError(fmt::format("haply-events-port {}", wrong_port(std::to_string(options_.events_port))));
    for (const auto& [name, id] : {std::pair("haply-device-id", &options_.device_id), std::pair("haply-grip-id", &options_.grip_id)})
        if (!id->empty() && !is_plain(*id)) throw MismatchError(fmt::format("{} must be at most 64 letters, digits, - and _", name));
    counts_.gate = counts_.damping = unknown;
}

HaplyDevice::~HaplyDevice() {
    stop();
}

void HaplyDevice::start() {
    stop();
    failure_.clear();
    stopping_ = false;
    link_ = std::make_unique<Link>(*this);
    link_->open();
    alive_.store(true, std::memory_order_release);
    started_ = true;
    thread_ = std::thread([this] { link_->run(); });
}

DeviceSample HaplyDevice::read(double) noexcept {
    measured_.fetch();
    const Measured& m = measured_.front();
    DeviceSample sample;
    sample.position_m = m.position_m;
    sample.valid = m.ready && alive_.load(std::memory_order_acquire);
    sample.grasp = m.grasp && sample.valid;
    // by the clock, as exchanges do not keep the time of ticks
    sample.age_s = std::max(0.0, 1e-9 * static_cast<double>(now_ns() - m.asked_ns));
    return sample;
}

void HaplyDevice::write(const Eigen::Vector3d& force_N) noexcept {
    if (!started_) return;
    force_.back() = {force_N, now_ns()};
    force_.publish();
}

void HaplyDevice::stop() noexcept {
    started_ = false;
    stopping_.store(true, std::memory_order_release);
    if (thread_.joinable()) thread_.join();
    alive_.store(false, std::memory_order_release);
    link_.reset();
}

std::string HaplyDevice::failure() const {
    return alive_.load(std::memory_order_acquire) ? "" : failure_;
}

std::vector<std::pair<std::string, double>> HaplyDevice::statistics() const {
    const auto count = [](const std::atomic<long long>& n) { return static_cast<double>(n.load(std::memory_order_relaxed)); };
    const double exchanges = count(counts_.exchanges);
    return {{"exchanges", exchanges},
            {"exchange_mean_us", exchanges > 0 ? 1e-3 * count(counts_.exchanges_ns) / exchanges : 0},
            {"exchange_max_us", 1e-3 * count(counts_.longest_ns)},
            {"late_exchanges", count(counts_.late)},
            {"cut_off_forces", count(counts_.cut_off)},
            {"not_ready", count(counts_.not_ready)},
            {"force_gate_gain", counts_.gate},
            {"service_damping", counts_.damping},
            {"events_heard", counts_.events_heard ? 1.0 : 0.0},
            {"events", count(counts_.events)},
            {"error_events", count(counts_.errors)},
            {"safety_events", count(counts_.safety)},
            {"disconnections", count(counts_.disconnected)},
            {"foreign_events", count(counts_.foreign)}};
}

}  // namespace tissue
