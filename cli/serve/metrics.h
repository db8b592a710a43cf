#pragma once

#include <map>
#include <string>

#include "show.h"

namespace tissue::serve {

/// Counts of the server, besides those of the show.
struct Traffic {
    long long connections = 0;                 ///< accepted so far
    long long clients = 0;                     ///< WebSockets open now
    long long requests = 0, messages = 0;      ///< HTTP requests, messages of pages
    long long frames = 0, frames_dropped = 0;  ///< states sent; states left out because a page was not ready
    std::map<std::string, long long> refused;  ///< by kind
};

/// Metrics in the text format of Prometheus, version 0.0.4.
std::string metrics_text(const Show& show, const Traffic& traffic);

}  // namespace tissue::serve
