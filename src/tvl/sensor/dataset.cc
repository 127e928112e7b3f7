#include "tvl/sensor/dataset.h"

#include <algorithm>

#include "tvl/base/check.h"

namespace tvl {

DatasetSource::DatasetSource(const Dataset& dataset, size_t begin, size_t end)
    : dataset_(dataset), next_(begin), end_(std::min(end, dataset.size())) {
  TVL_CHECK_INPUT(next_ < end_) << dataset.setup().name << ": no frames in [" << begin << ", "
                                << end << "), the input has " << dataset.size();
}

std::optional<SensorFrame> DatasetSource::Next() {
  if (next_ >= end_) return std::nullopt;
  return dataset_.Frame(next_++);
}

}  // namespace tvl
