#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "messages.h"

namespace tissue::serve {

/// Whether a Host header names this machine as our page does: by an address in digits, or localhost. Another name could
/// be made to resolve to this machine by anyone (DNS rebinding).
bool is_own_host(std::string_view host);

/// Whether a page of this Origin was served by us under this Host. Programs other than browsers send no Origin.
bool is_own_origin(std::string_view origin, std::string_view host);

/// Whether two texts are equal. The time does not depend on where they differ.
bool same_secret(std::string_view a, std::string_view b);

/// Name of the cookie of the server on a port. Browsers keep cookies per host, and several servers may run on one.
std::string cookie_name(int port);

/// Value of `token` in the query of a request's target, or in the cookie of that port.
std::optional<std::string> token_in_query(std::string_view target);
std::optional<std::string> token_in_cookie(std::string_view cookies, int port);

/// Path of a request's target, without its query and without the path of a session (32 hexadecimal digits) before it.
/// The session may be an earlier one, whose page looks for its server again.
std::string_view path_of(std::string_view target);

/// Whether a text can be a token in a URL and a cookie without escaping: 16 to 128 letters, digits, - and _.
bool is_token(std::string_view token);

/// 128 random bits from the system, as 32 hexadecimal digits. Throws Error when the system gives none.
std::string draw_secret();

/// The parts of a request that decide whether it is let in.
struct Credentials {
    std::string_view host, origin, target, cookie;
    bool has_origin = false;
};

/// Why a request is refused; nullopt when it is let in. token: empty when none is required. port: the server's.
std::optional<Refusal> refuse(const Credentials& credentials, const std::string& token, int port);

}  // namespace tissue::serve
