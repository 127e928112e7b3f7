// Scans in .bin files without a header: float32 records of 3 to 8 numbers that begin with x y z.
// How many they are and what the others mean is recognised from the values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tvl/io/cloud/cloud_read.h"

namespace tvl {

struct BinLayout {
  // Names of the numbers of a record: x, y, z, then intensity, ring, time where they were
  // recognised, and `unknown` for the others.
  std::vector<std::string> fields;
  std::string note;  // e.g. "records of 5 floats: x y z intensity ring"
};

// KITTI's: x y z intensity.
BinLayout KittiBinLayout();

// Float32 numbers of one file, from its beginning, and the length of that file.
struct BinSample {
  std::vector<float> numbers;
  size_t file_bytes = 0;
};

// Numbers that a sample needs at most: some 10000 points tell enough.
inline constexpr size_t kBinSampleNumbers = 60000;

// The sample of file bytes in memory.
BinSample SampleOfBin(const uint8_t* data, size_t bytes);

// Of all lengths that divide (nearly) all files, the one whose columns are each of one kind: in a
// wrong length each column mixes coordinates with intensities and rings. Files of less than 200
// numbers tell nothing: theirs is KITTI's length of four where it divides them. Throws InputError
// beginning with `source` where no length fits: the files are no float32 points.
BinLayout RecogniseBinLayout(const std::vector<BinSample>& samples, const std::string& source);

// RecogniseBinLayout from the first few of `paths`. Files that cannot be read are left out; throws
// InputError beginning with the first path where none can, or no length fits.
BinLayout RecogniseBinFiles(const std::vector<std::string>& paths);

// The points of a file in memory. Throws InputError beginning with `source` where the length is no
// whole number of records.
CloudRead ParseBinPoints(const uint8_t* data, size_t bytes, const BinLayout& layout,
                         const std::string& source);

// ParseBinPoints of a file. Throws InputError beginning with `path`.
CloudRead ReadBinScan(const std::string& path, const BinLayout& layout);

}  // namespace tvl
