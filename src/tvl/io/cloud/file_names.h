// Files of a folder by their names: order, numbers, pairs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tvl {

// Whether `a` comes before `b` where runs of digits are compared as numbers: 2.pcd before 10.pcd.
bool NaturalLess(const std::string& a, const std::string& b);

// Paths of the files of `folder` with one of these extensions (lower case, with the dot; the files'
// may be in upper case), in natural order; hidden files are left out. Empty where there is no such
// folder.
std::vector<std::string> ListFiles(const std::filesystem::path& folder,
                                   const std::vector<std::string>& extensions);

// The last extension in lower case, with the dot.
std::string ExtensionOf(const std::string& path);

// The file's name without its extension, and without a second one that is a cloud's (x.pcd.bin).
std::string StemOf(const std::string& path);

// The number at the end of a name: digits, perhaps with a decimal point among them.
struct NameNumber {
  std::string prefix;  // what comes before it
  std::string text;    // e.g. "000017", "1317376000.123456"
};

// The number at the end of StemOf(path). "1317376000_123456789" (seconds, nanoseconds) is
// 1317376000.123456789.
std::optional<NameNumber> NumberOf(const std::string& path);

// That number where it is a whole one of up to 18 digits: a frame's.
std::optional<int64_t> FrameNumberOf(const std::string& path);

// For each scan the image of the same name or the same frame number; empty where there is none.
std::vector<std::string> PairByName(const std::vector<std::string>& scans,
                                    const std::vector<std::string>& images);

// The last part of a path, whatever slashes it ends with, for messages.
std::string NameOfFolder(const std::string& path);

}  // namespace tvl
