#pragma once

#include <optional>

#include "beast.h"
#include "limits.h"

namespace tissue::serve {

class Listener;

/// One connection that speaks HTTP, and may become a page's WebSocket.
class Visitor : public std::enable_shared_from_this<Visitor> {
   public:
    Visitor(Listener& server, Tcp::socket socket);

    void read();

   private:
    using Answer = http::response<http::string_body>;

    void have_read(Code error);
    void upgrade(const http::request<http::empty_body>& request);
    Answer text(http::status status, std::string words);
    void answer(Answer given);
    void close();

    Listener& server_;
    Seat seat_;
    Stream stream_;
    beast::flat_buffer buffer_{16 * 1024};
    std::optional<http::request_parser<http::empty_body>> parser_;
    Answer answer_;
    bool keep_ = false;
};

}  // namespace tissue::serve
