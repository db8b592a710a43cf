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

/// What happens on the stage: who of the clients leads the hand of each tool, what the demo does with the first, and what everyone is told. Knows no
/// network; one thread's. Times are seconds of any clock that only grows.
class Show {
   public:
    using Client = int;
    using Tell = std::function<void(Client, const std::string&)>;

    /// tell: sends a text to a client. It may not call back.
    Show(Stage& stage, Tell tell);

    void join(Client client);
    void leave(Client client);

    /// Does what a client says; the reason when it may not be said.
    std::optional<Refusal> hear(Client client, std::string_view text, double now_s);

    /// 60 times a second: moves the hand, looks at the newest state. True when frame() is a new one.
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
        double heard_s = 0;   ///< from the holder
    };
    bool is_held() const;
    bool held_by_other(Client client) const;   ///< any tool
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
    std::vector<Lead> leads_;                 ///< of each tool
    std::map<Client, std::string> clients_;   ///< and the control message each has heard last
    int wanted_;                              ///< model that was asked for last
    double idle_since_s_ = 0, turned_s_ = -1e9, before_s_ = -1;
    Near near_;
    double told_m_ = 0;                       ///< distance that everyone has heard last
    std::string learned_text_;                ///< the newest of a lesson
    Frame frame_;
    bool seen_ = false;                       ///< a state of the model that is on the stage
    Histogram tick_us_;                       ///< since the start
    double tick_us_sum_ = 0;
    double second_s_ = -1;                    ///< when the figures over the last second were made
    long long ticks_then_ = 0;
    Histogram second_us_;
    TickSummary summary_;
};

}  // namespace tissue::serve
