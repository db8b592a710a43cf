#pragma once

#include <string>

namespace tissue {

/// A folder that is held open: what is made, renamed and removed within it stays within it, whatever becomes of the names that led there. A link that
/// leads to it, at any place of its path, is followed only where this user or root owns it: one that another user planted is refused.
class OpenFolder {
   public:
    enum class Missing { refuse, make };

    /// A relative path begins at `from`, or where the program runs. `make`: the folders of the path that are missing. Throws FileError, which begins with `named`.
    OpenFolder(const std::string& path, const std::string& named, Missing missing = Missing::refuse);
    OpenFolder(const OpenFolder& from, const std::string& path, const std::string& named, Missing missing = Missing::refuse);
    explicit OpenFolder(int descriptor) : descriptor_(descriptor) {}
    OpenFolder(OpenFolder&& other) noexcept : descriptor_(other.descriptor_) { other.descriptor_ = -1; }
    OpenFolder& operator=(OpenFolder&&) = delete;
    ~OpenFolder();

    int descriptor() const { return descriptor_; }
    /// A path of what is within, for functions that take no descriptor.
    std::string path_of(const std::string& name) const;
    /// Forces its names onto the disk, after a rename: else a machine that loses power may come back with the old file. A failure is no error:
    /// content and names are whole either way, not every disk can do it, and a folder that may not be read cannot be asked.
    void keep_names() const noexcept;

   private:
    int descriptor_;
};

/// Where a file stands: its folder, and its name there.
struct FilePlace {
    OpenFolder folder;
    std::string name;
};

/// Of a file that is to be made; a link of its name is not followed, for the new file takes the link's place. Throws FileError, as OpenFolder.
FilePlace place_of(const std::string& file);

/// Of a file that is to be opened for writing: links of its name are followed as those on the way are, and none is left.
struct OpenPlace : FilePlace {
    int is_open_as;  ///< descriptor of this program that the name leads to, as /dev/stdout does, or a shell's >(...); -1: none
};
OpenPlace place_behind_links(const std::string& file);

}  // namespace tissue
