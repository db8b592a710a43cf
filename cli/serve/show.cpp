#include "show.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>

namespace tissue::serve {
namespace {

constexpr double silent_s = 2;      ///< a holder that sends nothing for this long has let go
constexpr double turn_s = 0.5;      ///< least time between two changes of model: each stops the ticks for a moment
constexpr double crossed_s = 2;     ///< after a change of model, messages of pages may still refer to the previous one
constexpr double idle_s = 3;        ///< time without a holder until the demo starts by itself

}  // namespace

Show::Show(Stage& stage, Tell tell) : stage_(stage), tell_(std::move(tell)), wanted_(stage.index()) {
    near_.force_N = 0;
    for (int tool = 0; tool < stage.tools(); ++tool) leads_.push_back({Hand(stage.scene(), tool)});
    leads_.front().hand.demonstrate(-1);
}

void Show::join(Client client) {
    clients_[client] = "";
    tell_model(client);
    tell_control();
    tell_(client, near_text());
}

void Show::leave(Client client) {
    clients_.erase(client);
    for (Lead& lead : leads_)
        if (lead.holder == client) release(lead, before_s_);
    if (clients_.empty()) stage_.channel().pause(false);  // otherwise the pause could not be ended
    tell_control();
}

std::optional<Refusal> Show::hear(Client client, std::string_view text, double now_s) {
    const std::variant<Message, Refusal> parsed = parse_message(text);
    if (const Refusal* refusal = std::get_if<Refusal>(&parsed)) return *refusal;
    const Message& message = std::get<Message>(parsed);
    if (const ModelMessage* m = std::get_if<ModelMessage>(&message); m && m->model >= static_cast<int>(stage_.names().size()))
        return Refusal{"message", "no such model"};
    if (const DemoMessage* m = std::get_if<DemoMessage>(&message); m && m->place >= static_cast<int>(stage_.scene().places().size())) {
        if (now_s - turned_s_ < crossed_s) return {};
        return Refusal{"message", "no such place"};
    }
    if (const PointerMessage* m = std::get_if<PointerMessage>(&message); m && m->z_m.has_value() != stage_.model().is_solid()) {
        // the message refers to the previous model: it was sent before the change arrived
        if (now_s - turned_s_ < crossed_s) return {};
        return Refusal{"message", m->z_m ? "'z' is not allowed: this model is in the plane" : "'z' is missing: this model is in space"};
    }
    if (const PointerMessage* m = std::get_if<PointerMessage>(&message)) {
        if (m->tool >= stage_.tools()) return Refusal{"message", "no such tool"};
        const Client holder = leads_[static_cast<std::size_t>(m->tool)].holder;
        if (holder != nobody && holder != client) return {};
    } else if (held_by_other(client))
        return {};
    std::visit([&](const auto& m) { act(client, m, now_s); }, message);
    tell_control();
    return {};
}

void Show::act(Client client, const PointerMessage& m, double now_s) {
    Lead& lead = leads_[static_cast<std::size_t>(m.tool)];
    if (m.down) {
        if (!is_fixed())
            for (Lead& other : leads_)
                if (&other != &lead && other.hand.place() >= 0) other.hand.let_go();  // the demo ends
        lead.holder = client;
        lead.heard_s = now_s;
        Point at(m.z_m ? 3 : 2);
        at.head<2>() << m.x_m, m.y_m;
        if (m.z_m) at[2] = *m.z_m;
        lead.hand.follow(at);
        stage_.pointer(m.tool).grasp(m.grasp);
    } else if (lead.holder == client)
        release(lead, now_s);
}

void Show::act(Client, const PauseMessage& m, double) {
    stage_.channel().pause(m.on);
}

void Show::act(Client, const ResetMessage&, double) {
    stage_.reset();
}

void Show::act(Client, const DemoMessage& m, double now_s) {
    for (Lead& lead : leads_) release(lead, now_s);
    leads_.front().hand.demonstrate(m.place);
}

void Show::act(Client, const ModelMessage& m, double now_s) {
    wanted_ = m.model;
    turn(now_s);
}

/// Changes to the requested model, as soon as turn_s permits.
void Show::turn(double now_s) {
    if (wanted_ == stage_.index() || now_s - turned_s_ < turn_s) return;
    turned_s_ = now_s;
    const bool paused = stage_.channel().paused();
    const auto begun = std::chrono::steady_clock::now();
    for (int tool = 0; tool < stage_.tools(); ++tool) stage_.pointer(tool).grasp(false);
    try {
        stage_.turn_to(wanted_);
    } catch (const std::exception& e) {  // of another tool: the file has changed, or is gone
        std::cerr << "tissuectl serve: " << e.what() << '\n';
        wanted_ = stage_.index();
        for (const auto& [other, heard] : clients_) tell_model(other);
        return;
    }
    // a model that is made now may take seconds, and what pages sent meanwhile is about the model before
    turned_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    stage_.channel().pause(paused);
    for (Lead& lead : leads_) {
        lead.holder = nobody;
        lead.hand.show(stage_.scene());
    }
    idle_since_s_ = now_s;
    near_ = {-1, 0, 0};
    told_m_ = 0;
    seen_ = false;
    for (const auto& [other, heard] : clients_) {
        tell_model(other);
        tell_(other, near_text());
    }
}

/// The holder of a hand has let go.
void Show::release(Lead& lead, double now_s) {
    lead.holder = nobody;
    idle_since_s_ = now_s;
    stage_.pointer(static_cast<int>(&lead - leads_.data())).grasp(false);
    lead.hand.let_go();
}

bool Show::is_fixed() const {
    return std::any_of(leads_.begin(), leads_.end(), [](const Lead& lead) { return lead.holder != nobody; });
}

bool Show::held_by_other(Client client) const {
    return std::any_of(leads_.begin(), leads_.end(), [client](const Lead& lead) { return lead.holder != nobody && lead.holder != client; });
}

bool Show::step(double now_s) {
    const double elapsed = before_s_ < 0 ? 0 : std::min(now_s - before_s_, 0.1);
    before_s_ = now_s;
    turn(now_s);
    StateChannel& channel = stage_.channel();
    for (Lead& lead : leads_)
        if (lead.holder != nobody && now_s - lead.heard_s > silent_s) release(lead, now_s);
    Hand& first = leads_.front().hand;
    if (channel.paused()) idle_since_s_ = now_s;
    if (!is_fixed() && first.place() < 0 && now_s - idle_since_s_ > idle_s) first.demonstrate(-1);
    if (!channel.paused()) {
        for (std::size_t tool = 0; tool < leads_.size(); ++tool) stage_.pointer(static_cast<int>(tool)).aim(leads_[tool].hand.step(elapsed));
        // In tissue that relaxes, the remains of an indentation would change the next one, which could then not be
        // compared. A mesh that stays inverted would be indented as it is.
        const Scene& scene = stage_.scene();
        if (first.begins_press() && (scene.relaxes() || (seen_ && scene.away_from_rest(channel.state())))) stage_.reset();
    }
    tell_control();
    tell_learned();

    for (double us = 0; channel.pop_time(us);) {
        tick_us_.add(us);
        second_us_.add(us);
        tick_us_sum_ += us;
    }
    if (second_s_ < 0 || now_s - second_s_ >= 1) {
        const long long ticks = tick_us_.count();
        summary_.ticks_a_second = second_s_ < 0 ? 0 : static_cast<double>(ticks - ticks_then_) / (now_s - second_s_);
        summary_.p50_us = second_us_.percentile(0.5);
        summary_.p99_us = second_us_.percentile(0.99);
        second_us_ = {};
        ticks_then_ = ticks;
        second_s_ = now_s;
    }
    if (!channel.fetch()) return false;
    seen_ = true;
    const TickState& state = channel.state();
    const Near near = stage_.scene().near(state);
    // a contact that slips, or is lost and found again between two states, has a new distance at the same place
    constexpr double same_m = 5e-4;
    const bool another = near.place != near_.place || std::abs(near.distance_m - told_m_) > same_m;
    near_ = near;
    if (another) {
        told_m_ = near.distance_m;
        const std::string text = near_text();
        for (const auto& [client, heard] : clients_) tell_(client, text);
    }
    const StageCounts counts = stage_.counts();
    summary_.ticks = counts.ticks;
    summary_.misses = counts.misses;
    summary_.misses_program = counts.misses_program;
    summary_.clamped = counts.clamped;
    summary_.faults = counts.faults();
    summary_.clients = static_cast<long long>(clients_.size());
    frame_ = make_frame(state, stage_.scene(), near_, summary_);
    return true;
}

void Show::tell_model(Client client) {
    tell_(client, stage_.scene().message(stage_.names(), stage_.index()));
    if (!learned_text_.empty()) tell_(client, learned_text_);
}

/// Sends the result of a measurement to all clients.
void Show::tell_learned() {
    if (!stage_.lesson()) return;
    const std::optional<Lesson::News> news = stage_.lesson()->news();
    if (!news) return;
    if (news->field) stage_.scene().learn(*news->field);
    learned_text_ = stage_.scene().message(*news);
    for (const auto& [client, heard] : clients_) tell_(client, learned_text_);
}

std::string Show::near_text() const {
    if (near_.place < 0) return near_message(near_.place, near_.distance_m, {});
    const Place& place = stage_.scene().places()[static_cast<std::size_t>(near_.place)];
    return near_message(near_.place, near_.distance_m, place.outlines);
}

std::string Show::control_for(Client client) const {
    std::vector<const char*> holders;
    for (const Lead& lead : leads_) holders.push_back(holder_for(lead, client));
    const bool own = std::any_of(leads_.begin(), leads_.end(), [client](const Lead& lead) { return lead.holder == client; });
    return control_message(own ? "you" : held_by_other(client) ? "other" : holders.front(), holders, paused(), leads_.front().hand.place());
}

const char* Show::holder_for(const Lead& lead, Client client) const {
    return lead.holder == client ? "you" : lead.holder != nobody ? "other" : lead.hand.place() >= 0 ? "demo" : "nobody";
}

/// Sends the control message to each client for which it has changed.
void Show::tell_control() {
    for (auto& [client, heard] : clients_) {
        std::string now = control_for(client);
        if (now == heard) continue;
        tell_(client, now);
        heard = std::move(now);
    }
}

}  // namespace tissue::serve
