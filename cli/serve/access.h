#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "messages.h"

namespace tissue::serve {

/// Whether a Host header names this machine the way a page of ours does: an address in digits, or localhost. A name
/// could be anybody's that was made to resolve to us (DNS rebinding).
bool is_own_host(std::string_view host);

/// Whether a page of this Origin is one that we have served under this Host. Programs that are no browser send none.
bool is_own_origin(std::string_view origin, std::string_view host);

/// The same text, in a time that does not depend on where they differ.
bool same_secret(std::string_view a, std::string_view b);

/// The cookie of the server on a port: a browser keeps cookies by host alone, and there may be several servers.
std::string cookie_name(int port);

/// Value of `token` in the query of a request's target, or of the cookie of that port.
std::optional<std::string> token_in_query(std::string_view target);
std::optional<std::string> token_in_cookie(std::string_view cookies, int port);

/// Path of a request's target, without its query and without a session's own path (32 hexadecimal digits) before it: that of an earlier session, too,
/// from whose page the browser looks for its server again.
std::string_view path_of(std::string_view target);

/// A token that stands in a URL and a cookie as it is: 16 to 128 letters, digits, - and _.
bool is_token(std::string_view token);

/// 128 random bits of the system, in 32 hexadecimal digits. Throws Error when it gives none.
std::string draw_secret();

/// What a request brings to be let in.
struct Credentials {
    std::string_view host, origin, target, cookie;
    bool has_origin = false;
};

/// Why this request is not let in; nothing when it is. token: empty when none is wanted. port: the server's.
std::optional<Refusal> refuse(const Credentials& credentials, const std::string& token, int port);

}  // namespace tissue::serve
