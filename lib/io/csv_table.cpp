#include "io/csv_table.h"

#include <csv.h>
#include <fmt/format.h>

#include <algorithm>
#include <boost/locale/utf.hpp>
#include <memory>

#include "io/csv_columns.h"

namespace tissue {
namespace {

/// The separator of a header: the one that is most frequent outside quotes.
char separator_of(const std::string& header) {
    char best = ',';
    std::ptrdiff_t most = 0;
    for (const char separator : {',', ';', '\t'}) {
        bool quoted = false;
        const auto count = std::count_if(header.begin(), header.end(), [&](char c) { return c == '"' ? (quoted = !quoted, false) : !quoted && c == separator; });
        if (count > most) best = separator, most = count;
    }
    return best;
}

}  // namespace

bool CsvTable::next() {
    do {
        if (!next_text()) return false;
        check_encoding();
    } while (trimmed(text()).empty());
    fields_.clear();
    if (!is_comment()) split();
    return true;
}

void CsvTable::check_encoding() {
    const auto begins = [&](std::string_view bytes) { return number() == 1 && text().compare(0, bytes.size(), bytes) == 0; };
    if (begins("\xff\xfe") || begins("\xfe\xff") || text().find('\0') != std::string::npos)
        refuse("is not UTF-8, but UTF-16 or binary; save it as CSV in UTF-8");
    if (begins("PK\x03\x04")) refuse("is a spreadsheet, not text; save it as CSV in UTF-8");
    if (begins("\xef\xbb\xbf")) text_.erase(0, 3);
    using Utf = boost::locale::utf::utf_traits<char>;
    for (auto at = text_.cbegin(); at != text_.cend();) {
        const auto letter = at;
        if (boost::locale::utf::is_valid_codepoint(Utf::decode(at, text_.cend()))) continue;
        refuse(fmt::format("byte {} (0x{:02x}) is not UTF-8, but Latin-1 or similar; save the file as UTF-8", letter - text_.cbegin() + 1,
                           static_cast<unsigned char>(*letter)));
    }
}

void CsvTable::split() {
    if (separator_ == 0) separator_ = separator_of(text_);
    csv_parser parser;
    if (csv_init(&parser, CSV_STRICT | CSV_STRICT_FINI) != 0) refuse("cannot be read: not enough memory");
    const std::unique_ptr<csv_parser, void (*)(csv_parser*)> freed(&parser, csv_free);
    csv_set_delim(&parser, static_cast<unsigned char>(separator_));
    const auto take = [](void* field, std::size_t size, void* fields) {
        auto& all = *static_cast<std::vector<std::string>*>(fields);
        if (all.size() <= most_fields) all.emplace_back(static_cast<const char*>(field), size);
    };
    if (csv_parse(&parser, text_.data(), text_.size(), take, nullptr, &fields_) != text_.size() || csv_fini(&parser, take, nullptr, &fields_) != 0)
        refuse("has a quote that does not enclose a whole field, or does not end on its line");
    if (fields_.size() > most_fields) refuse_fields();
    while (fields_.size() > std::max<std::size_t>(columns_, 1) && trimmed(fields_.back()).empty()) fields_.pop_back();
    if (columns_ == 0) columns_ = fields_.size();
}

}  // namespace tissue
