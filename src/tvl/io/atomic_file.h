// Files that are either complete or not there.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>

namespace tvl {

// Lets `write` fill a temporary file beside `path` and renames it to `path` when all went well;
// makes the folder if it is missing. If `write` throws or the disk is full, `path` stays as it was
// and the temporary file is removed. Throws InputError naming the path.
void WriteAtomically(const std::string& path, const std::function<void(std::ostream&)>& write);

// The same for libraries that want a file name to write to: `write` is given the temporary name,
// which keeps the extension of `path` (image encoders choose the format by it).
void WriteAtomicallyByName(const std::string& path,
                           const std::function<void(const std::string&)>& write);

// The temporary name used for `path`: same folder, same extension, unique to the process.
std::string TemporaryNameFor(const std::string& path);

}  // namespace tvl
