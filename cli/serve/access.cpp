#include "access.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>

#include "error.h"

namespace tissue::serve {
namespace {

/// "127.0.0.1:8080" -> "127.0.0.1", "[::1]:8080" -> "::1"; empty where the port is malformed.
std::string name_of(std::string_view host) {
    std::string_view port;
    std::string_view name = host;
    if (!host.empty() && host[0] == '[') {
        const std::size_t end = host.find(']');
        if (end == std::string_view::npos) return {};
        name = host.substr(1, end - 1);
        port = host.substr(end + 1);
    } else if (const std::size_t colon = host.find(':'); colon != std::string_view::npos) {
        name = host.substr(0, colon);
        port = host.substr(colon);
    }
    const bool digits = port.empty() || (port[0] == ':' && port.size() > 1 && port.size() < 7 &&
                                         std::all_of(port.begin() + 1, port.end(), [](char c) { return c >= '0' && c <= '9'; }));
    return digits ? std::string(name) : std::string();
}

}  // namespace

bool is_own_host(std::string_view host) {
    const std::string name = name_of(host);
    unsigned char address[sizeof(in6_addr)];
    return name == "localhost" || inet_pton(AF_INET, name.c_str(), address) == 1 || inet_pton(AF_INET6, name.c_str(), address) == 1;
}

bool is_own_origin(std::string_view origin, std::string_view host) {
    constexpr std::string_view scheme = "http://";
    return origin.substr(0, scheme.size()) == scheme && origin.substr(scheme.size()) == host;
}

bool same_secret(std::string_view a, std::string_view b) {
    // every byte of the longer text is compared
    unsigned difference = a.size() == b.size() ? 0 : 1;
    for (std::size_t k = 0, n = std::max(a.size(), b.size()); k < n; ++k) {
        const unsigned x = k < a.size() ? static_cast<unsigned char>(a[k]) : 0, y = k < b.size() ? static_cast<unsigned char>(b[k]) : 0;
        difference |= x ^ y;
    }
    return difference == 0;
}

std::string_view path_of(std::string_view target) {
    constexpr std::size_t length = 32;  // of draw_secret()
    const std::string_view path = target.substr(0, target.find('?')), first = path.substr(0, length + 2);
    const bool session = first.size() == length + 2 && first.front() == '/' && first.back() == '/' &&
                         first.find_first_not_of("0123456789abcdef", 1) == length + 1;
    return session ? path.substr(length + 1) : path;
}

std::optional<std::string> token_in_query(std::string_view target) {
    const std::size_t mark = target.find('?');
    if (mark == std::string_view::npos) return {};
    std::string_view rest = target.substr(mark + 1);
    while (!rest.empty()) {
        const std::string_view part = rest.substr(0, rest.find('&'));
        if (part.substr(0, 6) == "token=") return std::string(part.substr(6));
        rest.remove_prefix(std::min(rest.size(), part.size() + 1));
    }
    return {};
}

std::string cookie_name(int port) {
    return fmt::format("tissue_token_{}", port);
}

std::optional<std::string> token_in_cookie(std::string_view rest, int port) {
    const std::string name = cookie_name(port) + "=";
    while (!rest.empty()) {
        std::string_view part = rest.substr(0, rest.find(';'));
        rest.remove_prefix(std::min(rest.size(), part.size() + 1));
        part.remove_prefix(std::min(part.size(), part.find_first_not_of(' ')));
        if (part.substr(0, name.size()) == name) return std::string(part.substr(name.size()));
    }
    return {};
}

bool is_token(std::string_view token) {
    return token.size() >= 16 && token.size() <= 128 && std::all_of(token.begin(), token.end(), [](char c) {
               return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '_';
           });
}

std::string draw_secret() {
    unsigned char bytes[16];
    if (::getrandom(bytes, sizeof bytes, 0) != static_cast<ssize_t>(sizeof bytes)) throw Error("the system gives no random numbers");
    std::string secret;
    for (const unsigned byte : bytes) secret += fmt::format("{:02x}", byte);
    return secret;
}

std::optional<Refusal> refuse(const Credentials& c, const std::string& token, int port) {
    if (!is_own_host(c.host)) return Refusal{"host", "this Host is not served"};
    if (c.has_origin && !is_own_origin(c.origin, c.host)) return Refusal{"origin", "a page of another Origin is refused"};
    if (token.empty()) return {};
    const std::string given = token_in_query(c.target).value_or(token_in_cookie(c.cookie, port).value_or(""));
    if (!same_secret(given, token)) return Refusal{"token", "the token is missing or wrong: open the address that the program printed"};
    return {};
}

}  // namespace tissue::serve
