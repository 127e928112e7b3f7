// Finds out which format a bag has and opens it.
#pragma once

#include <memory>
#include <string>

#include "tvl/io/ros/message_store.h"

namespace tvl {

// A file in one of the formats, or a folder with metadata.yaml of rosbag2, or with bag files.
// Never throws.
bool LooksLikeBag(const std::string& path);

// A folder's files are joined: those that metadata.yaml names, or all where there is none. Throws
// InputError for what is no bag, for file names that leave the folder, and for files compressed as
// a whole. Parts that are missing are warned of.
std::unique_ptr<MessageStore> OpenBagFile(const std::string& path);

}  // namespace tvl
