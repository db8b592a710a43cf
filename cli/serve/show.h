#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "frame.h"
#include "hand.h"
#include "haptic/histogram.h"
#include "messages.h"
#include "stage.h"

namespace tissue::serve {

/// Controls the stage: which client leads the hand of each tool, what the demo does with the first tool, and what the
/// clients are sent. Independent of the network; not thread-safe. Times are seconds of any monotonic clock.
class Show {
   public:
    using Client = int;
    using Tell = std::function<void(Client, const std::string&)>;

    /// tell: sends a text to a client. It must not call back.
    Show(Stage& stage, Tell tell);

    void join(Client client);
    void leave(Client client);

    /// Handles a client's message; returns the reason if it is refused.
    std::optional<Refusal> hear(Client client, std::string_view text, double now_s);

    /// Call 60 times a second: moves the hands and fetches the newest state. True when frame() is new.
    bool step(double now_s);
    const Frame& frame() const { return frame_; }

    const Stage& stage() const { return stage_; }
    const Histogram& tick_us() const { return tick_us_; }
    double tick_us_sum() const { return tick_us_sum_; }
    bool paused() const { return stage_.channel().paused(); }

   private:
    void act(Client client, const PointerMessage& m, double now_s);
    void act(Client client, const PauseMessage& m, double now_s);
    void act(Client client, const ResetMessage& m, double now_s);
    void act(Client client, const DemoMessage& m, double now_s);
    void act(Client client, const ModelMessage& m, double now_s);
    void turn(double now_s);
    struct Lead {
        Hand hand;
        Client holder = nobody;
        double heard_s = 0;   ///< time of the holder's last message
    };
    bool is_fixed() const;
    bool held_by_other(Client client) const;   ///< whether another client leads any tool
    void release(Lead& lead, double now_s);
    const char* holder_for(const Lead& lead, Client client) const;
    void tell_model(Client client);
    void tell_control();
    void tell_learned();
    std::string near_text() const;
    std::string control_for(Client client) const;

    static constexpr Client nobody = -1;
    Stage& stage_;
    Tell tell_;
    std::vector<Lead> leads_;                 ///< one per tool
    std::map<Client, std::string> clients_;   ///< client -> the last control message that it was sent
    int wanted_;                              ///< the model that was requested last
    double idle_since_s_ = 0, turned_s_ = -1e9, before_s_ = -1;
    Near near_;
    double told_m_ = 0;                       ///< distance that the clients were sent last
    std::string learned_text_;                ///< the newest message of the lesson
    Frame frame_;
    bool seen_ = false;                       ///< whether a state of the present model was fetched
    Histogram tick_us_;                       ///< since the start
    double tick_us_sum_ = 0;
    double second_s_ = -1;                    ///< start of the interval of the figures over a second
    long long ticks_then_ = 0;
    Histogram second_us_;
    TickSummary summary_;
};

}  // namespace tissue::serve
