#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "error.h"

/// Begins a fuzz target: a function of bytes, called by test_findings.cpp or by libFuzzer (under another name,
/// Makefile).
#define FUZZ_TARGET(reader) extern "C" int fuzz_##reader

namespace tissue {

/// Bytes as a file, for readers that need a file name. The file is in TMPDIR, else in memory, and is removed by the
/// destructor.
class FuzzFile {
   public:
    FuzzFile(const std::uint8_t* data, std::size_t size, const std::string& name) : file_(folder() + "/" + name) {
        std::ofstream(file_, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    }
    FuzzFile(const std::string& text, const std::string& name)
        : FuzzFile(reinterpret_cast<const std::uint8_t*>(text.data()), text.size(), name) {}
    ~FuzzFile() { ::unlink(file_.c_str()); }
    FuzzFile(const FuzzFile&) = delete;
    FuzzFile& operator=(const FuzzFile&) = delete;

    operator const std::string&() const { return file_; }

    /// A folder of this process, removed at a regular end of the process.
    static const std::string& folder() {
        struct Folder {
            std::string name = (std::filesystem::path(std::getenv("TMPDIR") ? std::getenv("TMPDIR") : "/dev/shm") / "tissue_fuzz_XXXXXX").string();
            Folder() {
                if (!mkdtemp(name.data())) throw std::logic_error("cannot make " + name);
            }
            ~Folder() {
                std::error_code ignored;
                std::filesystem::remove_all(name, ignored);
            }
        };
        static const Folder folder;
        return folder.name;
    }

   private:
    std::string file_;
};

/// Calls read(). Returns true if it succeeds, and false if it throws an Error of one line (a refusal). Other exceptions
/// are passed on.
template <class Read>
bool reads(Read&& read) {
    try {
        read();
        return true;
    } catch (const Error& e) {
        if (std::string(e.what()).find('\n') != std::string::npos) throw std::logic_error("a refusal of more than one line: " + std::string(e.what()));
        return false;
    }
}

/// Throws std::logic_error unless a condition holds that every input must satisfy.
inline void must(bool holds, const char* what) {
    if (!holds) throw std::logic_error(what);
}

}  // namespace tissue
