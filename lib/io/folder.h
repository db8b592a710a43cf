#pragma once

#include <string>

namespace tissue {

/// An open folder. What is made, renamed and removed in it stays in it, even if the names on its path change. A link on
/// its path is followed only if this user or root owns it; a link of another user is refused.
class OpenFolder {
   public:
    enum class Missing { refuse, make };

    /// A relative path starts at `from`, or at the working directory. Missing::make makes missing folders of the path.
    /// Throws FileError, which begins with `named`.
    OpenFolder(const std::string& path, const std::string& named, Missing missing = Missing::refuse);
    OpenFolder(const OpenFolder& from, const std::string& path, const std::string& named, Missing missing = Missing::refuse);
    explicit OpenFolder(int descriptor) : descriptor_(descriptor) {}
    OpenFolder(OpenFolder&& other) noexcept : descriptor_(other.descriptor_) { other.descriptor_ = -1; }
    OpenFolder& operator=(OpenFolder&&) = delete;
    ~OpenFolder();

    int descriptor() const { return descriptor_; }
    /// Path of an entry, for functions that do not take a descriptor.
    std::string path_of(const std::string& name) const;
    /// Flushes the folder's names to disk after a rename; otherwise the old file may be back after a power failure.
    /// Errors are ignored: content and names are consistent either way, not every disk supports it, and a folder
    /// without read permission cannot be flushed.
    void keep_names() const noexcept;

   private:
    int descriptor_;
};

/// A file's folder, and its name there.
struct FilePlace {
    OpenFolder folder;
    std::string name;
};

/// Place of a file to be made. A link of its name is not followed, because the new file replaces the link. Throws
/// FileError, as OpenFolder.
FilePlace place_of(const std::string& file);

/// Place of a file to be opened for writing. Links of its name are followed under the same rule as those on its path,
/// so that `name` is not a link.
struct OpenPlace : FilePlace {
    /// descriptor of this program to which the name leads, as for /dev/stdout or a shell's >(...); -1: none
    int is_open_as;
};
OpenPlace place_behind_links(const std::string& file);

}  // namespace tissue
