#include "metrics.h"

#include <fmt/format.h>

namespace tissue::serve {
namespace {

class Page {
   public:
    void metric(const char* name, const char* type, const char* help) {
        text_ += fmt::format("# HELP tissue_{0} {2}\n# TYPE tissue_{0} {1}\n", name, type, help);
    }
    template <class Number>
    void value(const char* name, const std::string& labels, Number value) {
        text_ += fmt::format("tissue_{}{} {}\n", name, labels, value);
    }
    template <class Number>
    void single(const char* name, const char* type, const char* help, Number number) {
        metric(name, type, help);
        value(name, "", number);
    }
    const std::string& text() const { return text_; }

   private:
    std::string text_;
};

/// Escapes quotes, backslashes and line ends in the value of a label.
std::string quoted(const std::string& text) {
    std::string out;
    for (char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        if (c == '\n') out += "\\n";
        else out += c;
    }
    return out;
}

}  // namespace

std::string metrics_text(const Show& show, const Traffic& traffic) {
    const StageCounts c = show.stage().counts();
    Page page;
    page.single("ticks_total", "counter", "Ticks of the simulation.", c.ticks);
    page.single("misses_total", "counter", "Periods that ended before their tick was done.", c.misses);
    page.single("misses_program_total", "counter", "Misses in which the tick itself used a whole period of processor time.", c.misses_program);
    page.single("clamped_total", "counter", "Ticks of a tool at the largest force.", c.clamped);
    page.single("slewed_total", "counter", "Ticks whose force would have risen too fast.", c.slewed);
    page.single("damped_total", "counter", "Ticks in which the passivity controller was at work.", c.damped);
    page.single("capped_total", "counter", "Ticks whose force was cut to what the bound on energy leaves.", c.capped);
    page.single("late_total", "counter", "Ticks so late that a device would have let go of the force.", c.late);
    page.single("lost_seconds_total", "counter", "Time that passed and that the tissue did not go through.", c.lost_s);
    page.metric("faults_total", "counter", "Refused positions of the pointers.");
    page.value("faults_total", "{kind=\"not_finite\"}", c.not_finite);
    page.value("faults_total", "{kind=\"jump\"}", c.jumps);
    page.value("faults_total", "{kind=\"stale\"}", c.stale);
    page.single("folded_total", "counter", "Ticks without force because an outline had no inside.", c.folded);
    page.single("unstable_total", "counter", "Ticks in which meshes were put to rest, since one had diverged or came to rest inverted.", c.unstable);
    page.metric("tick_seconds", "summary", "Work of a tick, device read to device write.");
    for (const auto& [label, share] : {std::pair("0.5", 0.5), {"0.99", 0.99}, {"0.999", 0.999}, {"1", 1.0}})
        page.value("tick_seconds", fmt::format("{{quantile=\"{}\"}}", label), 1e-6 * show.tick_us().percentile(share));
    page.value("tick_seconds_sum", "", 1e-6 * show.tick_us_sum());
    page.value("tick_seconds_count", "", show.tick_us().count());
    page.single("paused", "gauge", "1 while the simulation stands still.", show.paused() ? 1 : 0);
    page.metric("model_info", "gauge", "The model that runs.");
    page.value("model_info", fmt::format("{{name=\"{}\"}}", quoted(show.stage().names()[static_cast<std::size_t>(show.stage().index())])), 1);
    page.single("clients", "gauge", "Pages that are connected.", traffic.clients);
    page.single("connections_total", "counter", "Connections accepted.", traffic.connections);
    page.single("http_requests_total", "counter", "Requests answered.", traffic.requests);
    page.single("messages_total", "counter", "Messages of pages.", traffic.messages);
    page.single("frames_total", "counter", "States sent to pages.", traffic.frames);
    page.single("frames_dropped_total", "counter", "States left out because a page was not ready for them.", traffic.frames_dropped);
    page.metric("refused_total", "counter", "What was not let in, by reason.");
    for (const auto& [kind, count] : traffic.refused) page.value("refused_total", fmt::format("{{reason=\"{}\"}}", kind), count);
    return page.text();
}

}  // namespace tissue::serve
