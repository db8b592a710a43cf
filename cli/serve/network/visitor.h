#pragma once

#include <array>
#include <optional>

#include "beast.h"
#include "limits.h"

namespace tissue::serve {

class Listener;

/// One connection that speaks HTTP, and may become a page's WebSocket.
class Visitor : public std::enable_shared_from_this<Visitor> {
   public:
    Visitor(Listener& server, Seat seat, Tcp::socket socket);
    ~Visitor();
    Visitor(const Visitor&) = delete;
    Visitor& operator=(const Visitor&) = delete;

    void read();

    /// Ends it where it is late: with its first byte, its request, or in taking an answer.
    void check_time();

    /// Whether it gives its seat to a newcomer before another one does: who has not been admitted first, then who waits between two requests; of these
    /// one of the address with most connections, and then the oldest.
    bool goes_before(const Visitor& other) const;
    const Neighbour& neighbour() const { return seat_.neighbour(); }

    /// Ends it with a reason, which waits for nobody, and frees its seat.
    void send_off(http::status status, const std::string& reason);
    static void send_off(Tcp::socket& socket, http::status status, const std::string& reason);

   private:
    struct Answer {
        http::response<http::empty_body> head;
        std::string text;
        std::string_view file;  ///< of the page; else `text`
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
    std::optional<beast::buffers_suffix<std::array<asio::const_buffer, 2>>> rest_;  ///< of the answer that is being written
    std::size_t written_ = 0;
    Clock::time_point since_ = Clock::now();  ///< of what it does now
    bool keep_ = false, admitted_ = false, spoke_ = false, answering_ = false, lingering_ = false, gone_ = false;
};

}  // namespace tissue::serve
