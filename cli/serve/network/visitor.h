#pragma once

#include <array>
#include <optional>

#include "beast.h"
#include "limits.h"

namespace tissue::serve {

class Listener;

/// One HTTP connection, which may become the WebSocket of a page.
class Visitor : public std::enable_shared_from_this<Visitor> {
   public:
    Visitor(Listener& server, Seat seat, Tcp::socket socket);
    ~Visitor();
    Visitor(const Visitor&) = delete;
    Visitor& operator=(const Visitor&) = delete;

    void read();

    /// Closes the connection if it is late: with its first byte, with its request, or in receiving an answer.
    void check_time();

    /// Whether this connection is closed before `other` to make room. First are those without a valid request, or that
    /// are closing; then those that receive no answer at present. Among equals the first is of the address with most
    /// connections, then the oldest.
    bool goes_before(const Visitor& other) const;
    const Neighbour& neighbour() const { return seat_.neighbour(); }

    /// Sends a reason without waiting, closes, and frees the seat.
    void send_off(http::status status, const std::string& reason);
    static void send_off(Tcp::socket& socket, http::status status, const std::string& reason);

   private:
    struct Answer {
        http::response<http::empty_body> head;
        std::string text;
        std::string_view file;  ///< a file of the page; if empty, `text` is sent
    };

    void read_header();
    void have_read(Code error);
    Answer answer_to(const http::request<http::empty_body>& request);
    Answer page(const http::request<http::empty_body>& request, std::string_view path);
    std::optional<Answer> refusal(const http::request<http::empty_body>& request);
    void upgrade(const http::request<http::empty_body>& request);
    Answer refuse(const char* kind, http::status status, std::string words);
    static Answer text(http::status status, std::string words);
    void answer(Answer given);
    void write();
    void linger();
    void discard(int times);
    void close();
    void leave();

    Listener& server_;
    Seat seat_;
    Stream stream_;
    beast::flat_buffer buffer_{16 * 1024};
    std::optional<http::request_parser<http::empty_body>> parser_;
    Answer answer_;
    std::string head_;
    /// the rest of the answer that is being sent
    std::optional<beast::buffers_suffix<std::array<asio::const_buffer, 2>>> rest_;
    std::size_t written_ = 0;
    Clock::time_point since_ = Clock::now();  ///< start of the present action
    bool keep_ = false, admitted_ = false, spoke_ = false, answering_ = false, lingering_ = false, gone_ = false;
};

}  // namespace tissue::serve
