#include "tvl/io/atomic_file.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tvl/base/check.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;

// Removes the file unless told that it has become the final one.
class Leftover {
 public:
  explicit Leftover(const std::string& path) : path_(path) {}
  ~Leftover() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove(path_, ignored);
  }
  Leftover(const Leftover&) = delete;
  Leftover& operator=(const Leftover&) = delete;
  void Keep() { path_.clear(); }

 private:
  std::string path_;
};

}  // namespace

std::string TemporaryNameFor(const std::string& path) {
  const fs::path file(path);
  return (file.parent_path() / ("." + file.stem().string() + ".part" + std::to_string(getpid()) +
                                file.extension().string()))
      .string();
}

void WriteAtomicallyByName(const std::string& path,
                           const std::function<void(const std::string&)>& write) {
  std::error_code error;
  const fs::path folder = fs::path(path).parent_path();
  if (!folder.empty()) fs::create_directories(folder, error);
  TVL_CHECK_INPUT(!error) << folder.string() << ": cannot be made: " << error.message();
  const std::string temporary = TemporaryNameFor(path);
  Leftover leftover(temporary);
  write(temporary);
  fs::rename(temporary, path, error);
  TVL_CHECK_INPUT(!error) << path << ": cannot be written: " << error.message();
  leftover.Keep();
}

void WriteAtomically(const std::string& path, const std::function<void(std::ostream&)>& write) {
  WriteAtomicallyByName(path, [&](const std::string& temporary) {
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    TVL_CHECK_INPUT(out.good()) << path << ": cannot be written";
    write(out);
    out.close();
    TVL_CHECK_INPUT(!out.fail()) << path << ": writing failed, is the disk full?";
  });
}

}  // namespace tvl
