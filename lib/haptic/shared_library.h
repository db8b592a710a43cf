#pragma once

#include <dlfcn.h>

#include <string>

namespace tissue {

/// A vendor's library that is loaded while the program runs, so that building needs no SDK. It is unloaded by the
/// destructor: what was found in it must not be called afterwards.
class SharedLibrary {
   public:
    /// file: a path, or a name that the system's loader looks up. Where it cannot be loaded, loaded() is false and
    /// error() states why.
    explicit SharedLibrary(const std::string& file) : file_(dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
        if (!file_) error_ = dlerror();
    }
    ~SharedLibrary() {
        if (file_) dlclose(file_);
    }
    SharedLibrary(const SharedLibrary&) = delete;
    SharedLibrary& operator=(const SharedLibrary&) = delete;

    bool loaded() const { return file_ != nullptr; }
    const std::string& error() const { return error_; }

    /// Sets `function` to the library's function of this name, to null where there is none. Returns whether there is
    /// one. The type of `function` is not checked by anything.
    template <class Function>
    bool find(const char* name, Function& function) const {
        function = reinterpret_cast<Function>(dlsym(file_, name));
        return function != nullptr;
    }

   private:
    void* file_;
    std::string error_;
};

}  // namespace tissue
