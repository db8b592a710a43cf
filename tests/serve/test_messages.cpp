#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "../../cli/serve/access.h"
#include "../../cli/serve/messages.h"
#include "../haptic/haptic_example.h"

using namespace tissue;
using namespace tissue::serve;

namespace {

template <class Kind>
const Kind* as(const std::variant<Message, Refusal>& parsed) {
    const Message* message = std::get_if<Message>(&parsed);
    return message ? std::get_if<Kind>(message) : nullptr;
}

/// Reason of the refusal; "" if the text is a message.
std::string refused(std::string_view text) {
    const auto parsed = parse_message(text);
    const Refusal* refusal = std::get_if<Refusal>(&parsed);
    return refusal ? refusal->reason : "";
}

}  // namespace

TEST_CASE("every type of page message is parsed", "[serve]") {
    const auto pointer = parse_message(R"({"type":"pointer","x":0.05,"y":-1e-3,"down":true})");
    REQUIRE(as<PointerMessage>(pointer));
    CHECK((as<PointerMessage>(pointer)->x_m == 0.05 && as<PointerMessage>(pointer)->y_m == -1e-3 && as<PointerMessage>(pointer)->down));
    // keys in any order; integers too
    const auto whole = parse_message(R"({"down":false,"y":0,"x":1,"type":"pointer"})");
    REQUIRE(as<PointerMessage>(whole));
    CHECK((as<PointerMessage>(whole)->x_m == 1 && !as<PointerMessage>(whole)->down));
    CHECK_FALSE(as<PointerMessage>(whole)->z_m);
    const auto in_space = parse_message(R"({"type":"pointer","x":1,"y":2,"z":-0.5,"down":true})");
    REQUIRE(as<PointerMessage>(in_space));
    CHECK(as<PointerMessage>(in_space)->z_m == -0.5);
    CHECK(as<PauseMessage>(parse_message(R"({"type":"pause","on":true})")));
    CHECK(as<ResetMessage>(parse_message(R"( {"type" : "reset"} )")));
    const auto demo = parse_message(R"({"type":"demo","place":-1})"), model = parse_message(R"({"type":"model","model":2})");
    REQUIRE((as<DemoMessage>(demo) && as<ModelMessage>(model)));
    CHECK((as<DemoMessage>(demo)->place == -1 && as<ModelMessage>(model)->model == 2));
}

TEST_CASE("an invalid page message is refused with the reason", "[serve]") {
    for (const char* text : {"", "{", "hello", "[1,", "{\"type\":\"reset\"}}", "\xff\xfe", R"({"type":"pointer","x":1e999,"y":0,"down":true})",
                             R"({"type":"pointer","x":NaN,"y":0,"down":true})"})
        CHECK(refused(text) == "not JSON");
    CHECK(refused("[]") == "a message must be a JSON object");
    CHECK(refused("{}") == "a message must have a 'type'");
    CHECK(refused(R"({"type":1})") == "a message must have a 'type'");
    CHECK(refused(R"({"type":"fly"})").find("one of pointer") != std::string::npos);
    CHECK(refused(R"({"type":"pointer","x":0,"down":true})") == "'y' is missing");
    CHECK(refused(R"({"type":"pointer","x":"0","y":0,"down":true})") == "'x' must be a finite number");
    CHECK(refused(R"({"type":"pointer","x":0,"y":0,"down":1})") == "'down' must be true or false");
    CHECK(refused(R"({"type":"pointer","x":0,"y":0,"down":true,"w":0})") == "a key that a message of this type does not have");
    CHECK(refused(R"({"type":"pointer","x":0,"y":0,"down":true,"z":"0"})") == "'z' must be a finite number");
    CHECK(refused(R"({"type":"reset","x":0})") == "a key that a message of this type does not have");
    for (const char* k : {"-2", "0.5", "1e9", "99999999999999999999", "18446744073709551615", "null"})
        CHECK(refused(R"({"type":"demo","place":)" + std::string(k) + "}").find("'place' must be an integer") == 0);
    CHECK(refused(R"({"type":"model","model":-1})").find("'model' must be") == 0);
    CHECK(refused(std::string(longest_message, ' ') + "{}").find("longer than 1024 bytes") != std::string::npos);
    CHECK(refused(std::string(500, '[') + std::string(500, ']')) == "a message must be a JSON object");
}

TEST_CASE("a pointer message has the number of its tool; the first tool is the default", "[serve]") {
    const auto tool_of = [](const std::string& tool) {
        const auto parsed = parse_message(R"({"type":"pointer","x":0.05,"y":0.1,"down":true)" + tool + "}");
        const PointerMessage* m = as<PointerMessage>(parsed);
        return m ? m->tool : -1;
    };
    CHECK(tool_of("") == 0);
    CHECK(tool_of(R"(,"tool":1)") == 1);
    for (const char* wrong : {R"(,"tool":-1)", R"(,"tool":0.5)", R"(,"tool":"1")", R"(,"tool":1e9)"}) CHECK(tool_of(wrong) == -1);
}

TEST_CASE("each of 20000 mutated and random texts is a valid message or is refused with a reason", "[serve]") {
    const std::string seeds[] = {R"({"type":"pointer","x":0.05,"y":-1e-3,"down":true})", R"({"type":"pause","on":true})",
                                 R"({"type":"reset"})", R"({"type":"demo","place":-1})", R"({"type":"model","model":0})"};
    Draw draw(2008);
    long messages = 0, refusals = 0;
    for (int k = 0; k < 20000; ++k) {
        std::string text = seeds[draw.below(5)];
        const int edits = draw.below(4);
        for (int e = 0; e < edits; ++e) {
            const auto at = static_cast<std::size_t>(draw.below(static_cast<int>(text.size()) + 1));
            const char byte = static_cast<char>(draw.below(256));
            switch (draw.below(5)) {
                case 0: text.insert(at, 1, byte); break;
                case 1: if (at < text.size()) text[at] = byte; break;
                case 2: text.erase(at, static_cast<std::size_t>(draw.below(6))); break;
                case 3: text.insert(at, text.substr(0, static_cast<std::size_t>(draw.below(20)))); break;
                default: text.insert(at, std::string(static_cast<std::size_t>(draw.below(60)), "0[{9-e\""[draw.below(7)])); break;
            }
        }
        if (draw.below(10) == 0)
            for (char& c : text) c = static_cast<char>(draw.below(256));
        const auto parsed = parse_message(text);
        if (const PointerMessage* p = as<PointerMessage>(parsed)) REQUIRE((std::isfinite(p->x_m) && std::isfinite(p->y_m) && std::isfinite(p->z_m.value_or(0))));
        if (const DemoMessage* d = as<DemoMessage>(parsed)) REQUIRE(d->place >= -1);
        if (const ModelMessage* m = as<ModelMessage>(parsed)) REQUIRE(m->model >= 0);
        if (const Refusal* r = std::get_if<Refusal>(&parsed)) {
            REQUIRE(!r->reason.empty());
            REQUIRE(r->reason.size() < 124);  // fits into a close frame
            ++refusals;
        } else
            ++messages;
    }
    CHECK(messages > 4000);
    CHECK(refusals > 4000);
}

TEST_CASE("messages to the page are JSON with the keys of the protocol", "[serve]") {
    using Json = nlohmann::json;
    CHECK(Json::parse(bye_message("it \"ends\"\n")) == Json{{"type", "bye"}, {"reason", "it \"ends\"\n"}});
    CHECK(Json::parse(near_message(3, 0.25, {})) == Json{{"type", "near"}, {"place", 3}, {"distance_m", 0.25}, {"outline", Json::array()}});
    NodeField u(2, 2);
    u << 0.00123456789, -0.002, 0, 1e-9;
    CHECK(Json::parse(near_message(0, 0, {{0.01, u}}))["outline"] == Json::parse("[[0.01, [[0.0012346, -0.002], [0.0, 0.0]]]]"));
    CHECK(Json::parse(control_message("you", {"you", "other"}, true, -1)) == Json{{"type", "control"}, {"holder", "you"}, {"holders", {"you", "other"}}, {"paused", true}, {"place", -1}});
}

TEST_CASE("a Host header is accepted if it is a numeric address or localhost", "[serve]") {
    for (const char* host : {"127.0.0.1", "127.0.0.1:8080", "localhost:1", "localhost", "[::1]:8080", "[::1]", "192.168.1.5:80"})
        CHECK(is_own_host(host));
    for (const char* host : {"", "evil.example", "evil.example:8080", "127.0.0.1.evil.example", "localhost.evil.example", "127.0.0.1:",
                             "127.0.0.1:x", "127.0.0.1:8080:1", "127.1", "0x7f000001", "[::1", "[evil]", "::1]:1", "127.0.0.1@evil.example",
                             "user@127.0.0.1", " 127.0.0.1", "localhost:1234567"})
        CHECK_FALSE(is_own_host(host));
}

TEST_CASE("an Origin header is accepted only if it is the page's own", "[serve]") {
    CHECK(is_own_origin("http://127.0.0.1:8080", "127.0.0.1:8080"));
    for (const char* origin : {"http://evil.example", "null", "", "https://127.0.0.1:8080", "http://127.0.0.1:8081", "http://127.0.0.1",
                               "http://127.0.0.1:8080.evil.example", "http://127.0.0.1:8080/", "HTTP://127.0.0.1:8080x"})
        CHECK_FALSE(is_own_origin(origin, "127.0.0.1:8080"));
}

TEST_CASE("a complete token in query or cookie gives access and a partial one does not", "[serve]") {
    const std::string token = "0123456789abcdef";
    const auto why = [&](std::string_view target, std::string_view cookie) {
        const auto refusal = refuse({"127.0.0.1:1", "", target, cookie, false}, token, 8080);
        return refusal ? refusal->kind : std::string();
    };
    CHECK(why("/?token=0123456789abcdef", "").empty());
    CHECK(why("/ws?a=b&token=0123456789abcdef&c", "").empty());
    CHECK(why("/page.js", "other=1; tissue_token_8080=0123456789abcdef").empty());
    for (const char* target : {"/", "/?token=", "/?token=0123456789abcde", "/?token=0123456789abcdef0", "/?token=0123456789abcdeF",
                               "/?xtoken=0123456789abcdef", "/token=0123456789abcdef"})
        CHECK(why(target, "") == "token");
    CHECK(why("/", "xtissue_token_8080=0123456789abcdef") == "token");
    for (const char* of_another : {"tissue_token=0123456789abcdef", "tissue_token_8081=0123456789abcdef", "tissue_token_80801=0123456789abcdef"})
        CHECK(why("/", of_another) == "token");
    // two servers on one host
    CHECK(why("/", "tissue_token_8081=fedcba9876543210; tissue_token_8080=0123456789abcdef").empty());
    CHECK(draw_secret() != draw_secret());
    CHECK(is_token(draw_secret()));
    CHECK(why("/?token=wrong", "tissue_token_8080=0123456789abcdef") == "token");
    CHECK_FALSE(refuse({"127.0.0.1:1", "", "/", "", false}, "", 8080));
    CHECK(std::string(refuse({"evil.example", "", "/", "", false}, "", 8080)->kind) == "host");
    CHECK(std::string(refuse({"127.0.0.1:1", "null", "/", "", true}, "", 8080)->kind) == "origin");
    CHECK(is_token(token));
    for (const char* bad : {"", "short", "0123456789abcde;", "0123456789abcdef\n", "0123456789 abcdef"}) CHECK_FALSE(is_token(bad));
    CHECK(path_of("/ws?x=/y") == "/ws");
    CHECK(path_of("/") == "/");
    const std::string session = "/" + draw_secret();
    CHECK(path_of(session + "/") == "/");
    CHECK(path_of(session + "/ws?token=" + token) == "/ws");
    for (const std::string& other : std::vector<std::string>{session, session + "0/ws", session.substr(0, 32) + "/ws", "/0123456789ABCDEF0123456789abcdef/ws", "/?" + session + "/ws"})
        CHECK(path_of(other) == other.substr(0, other.find('?')));
}
