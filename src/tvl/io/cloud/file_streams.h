// Streams of scans and images that lie in files of their own.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tvl/io/cloud/bin_points.h"
#include "tvl/io/cloud/cloud_read.h"
#include "tvl/io/recording.h"

namespace tvl {

// Reads one scan; throws InputError.
using ReadScanFile = std::function<CloudRead(const std::string& path)>;

// The reader for the extension of `path` (.bin, .pcd, .ply, .las; upper case too); `bin` is the
// layout of .bin files. Throws InputError beginning with `path` for others, with what to do for
// .laz.
ReadScanFile ReaderOf(const std::string& path, const BinLayout& bin);

// A file is read when it is asked for and not kept. `stamps` is empty or one a path. A file that is
// not there is a kMissingScan, an empty one a kEmptyScan, anything else that is wrong with it a
// kTruncatedScan; the message begins with the path.
std::unique_ptr<ScanStream> MakeFileScanStream(std::vector<std::string> paths,
                                               std::vector<Timestamp> stamps, ReadScanFile read);

// Width and height every image must have; 0: any.
struct ImageSize {
  int width_px = 0, height_px = 0;
};

// As above for images (image_file.h); one that is not there is a kMissingImage.
std::unique_ptr<ImageStream> MakeFileImageStream(std::vector<std::string> paths,
                                                 std::vector<Timestamp> stamps, ImageSize size);

// Of the first of `paths` that can be read; 0 x 0 where none of the first few can.
ImageSize SizeOfFirstImage(const std::vector<std::string>& paths);

// What the scans have beside their points, e.g. "intensity, ring, timestamp as time; 64 x 1024
// points", from the first of `paths` that can be read; the reader's own notes follow. Throws the
// InputError of the first where none of the first few can.
std::vector<std::string> DescribeScans(const std::vector<std::string>& paths,
                                       const ReadScanFile& read);

}  // namespace tvl
