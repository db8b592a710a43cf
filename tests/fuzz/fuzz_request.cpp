// The parts of a request that decide about access: lines of host, origin, target and cookie.
#include <algorithm>

#include "../../cli/serve/access.h"
#include "../../cli/serve/page.h"
#include "fuzz_file.h"

using namespace tissue;
using namespace tissue::serve;

FUZZ_TARGET(request)(const std::uint8_t* data, std::size_t size) {
    static const std::string token = "0123456789abcdef";
    std::string_view rest(reinterpret_cast<const char*>(data), size), part[4];
    for (std::string_view& p : part) {
        p = rest.substr(0, rest.find('\n'));
        rest.remove_prefix(std::min(rest.size(), p.size() + 1));
    }
    const Credentials credentials{part[0], part[1], part[2], part[3], !part[1].empty()};
    const bool open = !refuse(credentials, "", 8080), let_in = !refuse(credentials, token, 8080);
    must(open || !let_in, "a request is accepted with a token and refused without one");
    must(!let_in || part[2].find(token) != std::string_view::npos || part[3].find(token) != std::string_view::npos, "a request is accepted without the token");
    page_file(std::string(path_of(part[2])));
    is_token(part[3]);
    return 0;
}
