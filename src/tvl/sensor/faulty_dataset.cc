#include "tvl/sensor/faulty_dataset.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {
namespace {

using Delivery = FaultyDataset::Delivery;
using Kind = DataFault::Kind;
using Range = DataFault::Range;

// How a fault is written. Arguments: f a frame, r a range of frames, * ranges, n a count, s
// seconds, m metres, ? an optional seed.
struct Form {
  const char* name;
  Kind kind;
  const char* arguments;
};
constexpr Form kForms[] = {
    {"late", Kind::kLate, "fs"},       {"odd", Kind::kOddLate, "s"},
    {"jitter", Kind::kJitter, "s?"},   {"round", Kind::kRound, "s"},
    {"clock", Kind::kClockStep, "fs"}, {"equal", Kind::kEqual, ""},
    {"drop", Kind::kDrop, "*"},        {"every", Kind::kEvery, "n"},
    {"repeat", Kind::kRepeat, "n"},    {"hold", Kind::kHold, "fn"},
    {"renumber", Kind::kRenumber, ""}, {"blackout", Kind::kBlackout, "r"},
    {"kidnap", Kind::kKidnap, "rm"},
};

const Form& FormOf(Kind kind) {
  return *std::find_if(std::begin(kForms), std::end(kForms),
                       [&](const Form& form) { return form.kind == kind; });
}

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

template <typename T>
T Number(const std::string& text, const std::string& fault) {
  T value{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  TVL_CHECK_INPUT(error == std::errc() && stop == end)
      << "fault '" << fault << "': '" << text << "' is not what is wanted there";
  return value;
}

Range ParseRange(const std::string& text, const std::string& fault) {
  const size_t dash = text.find('-');
  if (dash == std::string::npos) {
    const auto frame = Number<size_t>(text, fault);
    return {frame, frame};
  }
  const Range range{Number<size_t>(text.substr(0, dash), fault),
                    Number<size_t>(text.substr(dash + 1), fault)};
  TVL_CHECK_INPUT(range.first <= range.last) << "fault '" << fault << "': want A-B with A <= B";
  return range;
}

void SetArgument(char argument, const std::string& text, const std::string& name, DataFault* f) {
  switch (argument) {
    case 'f': {
      const auto frame = Number<size_t>(text, name);
      f->frames.push_back({frame, frame});
      break;
    }
    case 'r':
    case '*':
      f->frames.push_back(ParseRange(text, name));
      break;
    case 'n':
      f->count = Number<size_t>(text, name);
      break;
    case 's':
      f->seconds = Number<double>(text, name);
      break;
    case 'm':
      f->metres = Number<double>(text, name);
      break;
    default:
      f->seed = Number<uint64_t>(text, name);
  }
}

DataFault ParseFault(const std::string& text) {
  const size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  const Form* form = std::find_if(std::begin(kForms), std::end(kForms),
                                  [&](const Form& known) { return name == known.name; });
  std::string known;
  for (const Form& each : kForms) known += std::string(" ") + each.name;
  TVL_CHECK_INPUT(form != std::end(kForms)) << "fault '" << text << "': unknown; known:" << known;
  const std::string wanted = form->arguments;
  const std::vector<std::string> given =
      Split(colon == std::string::npos ? "" : text.substr(colon + 1), ',');
  const bool is_list = wanted == "*";
  const size_t least = wanted.size() - (wanted.find('?') == std::string::npos ? 0 : 1);
  TVL_CHECK_INPUT(given.size() >= least && (is_list || given.size() <= wanted.size()))
      << "fault '" << text << "': " << name << " wants " << least << " argument"
      << (least == 1 ? "" : "s") << ", got " << given.size();
  DataFault fault;
  fault.kind = form->kind;
  for (size_t i = 0; i < given.size(); ++i) {
    SetArgument(is_list ? '*' : wanted[i], given[i], text, &fault);
  }
  return fault;
}

// What a fault needs to know of the recording.
struct Recording {
  size_t size = 0;
  int64_t period_ns = 0;
  std::vector<Rigid3d> truth;
};

// The median step of the stamps.
int64_t NominalPeriod_ns(const std::vector<Delivery>& deliveries) {
  std::vector<int64_t> steps;
  for (size_t i = 1; i < deliveries.size(); ++i) {
    steps.push_back(deliveries[i].stamp.ns - deliveries[i - 1].stamp.ns);
  }
  if (steps.empty()) return 100'000'000;  // a single frame: 10 Hz, never used as a step
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

int64_t ToNs(double seconds) { return Timestamp::FromSeconds(seconds).ns; }

bool IsIn(const std::vector<Range>& ranges, size_t frame) {
  return std::any_of(ranges.begin(), ranges.end(), [&](const Range& range) {
    return frame >= range.first && frame <= range.last;
  });
}

void ShiftStamps(const DataFault& fault, const Recording& recording, std::vector<Delivery>* all) {
  for (size_t i = 0; i < all->size(); ++i) {
    Delivery& d = (*all)[i];
    switch (fault.kind) {
      case Kind::kLate:
        if (d.source == fault.frames[0].first) d.stamp.ns += ToNs(fault.seconds);
        break;
      case Kind::kOddLate:
        if (i % 2 == 1) d.stamp.ns += ToNs(fault.seconds);
        break;
      case Kind::kJitter:
        d.stamp.ns += ToNs(fault.seconds * Rng(fault.seed, i).Normal());
        break;
      case Kind::kRound: {
        const double steps = std::round(d.stamp.seconds() / fault.seconds);
        d.stamp = Timestamp::FromSeconds(steps * fault.seconds);
        break;
      }
      case Kind::kClockStep:
        if (d.source >= fault.frames[0].first) d.stamp.ns += ToNs(fault.seconds);
        break;
      case Kind::kEqual:
        d.stamp = all->front().stamp;
        break;
      default:  // kRenumber
        d.stamp.ns = all->front().stamp.ns + static_cast<int64_t>(i) * recording.period_ns;
    }
  }
}

template <typename Predicate>
void Remove(const Predicate& is_lost, std::vector<Delivery>* all) {
  all->erase(std::remove_if(all->begin(), all->end(), is_lost), all->end());
}

// Every frame `count` times, between its stamp and the next.
std::vector<Delivery> Repeated(const std::vector<Delivery>& all, size_t count, int64_t period_ns) {
  std::vector<Delivery> repeated;
  for (size_t i = 0; i < all.size(); ++i) {
    const int64_t step_ns = i + 1 < all.size() ? all[i + 1].stamp.ns - all[i].stamp.ns : period_ns;
    for (size_t k = 0; k < count; ++k) {
      Delivery copy = all[i];
      const auto n = static_cast<int64_t>(count), copy_number = static_cast<int64_t>(k);
      copy.stamp.ns += step_ns * copy_number / n;
      repeated.push_back(copy);
    }
  }
  return repeated;
}

std::vector<Delivery> Held(const std::vector<Delivery>& all, const DataFault& fault,
                           int64_t period_ns) {
  std::vector<Delivery> held;
  int64_t later = 0;
  for (const Delivery& d : all) {
    Delivery copy = d;
    const auto add = [&] {
      copy.stamp.ns = d.stamp.ns + later * period_ns;
      held.push_back(copy);
    };
    add();
    if (later > 0 || d.source != fault.frames[0].first) continue;
    for (size_t k = 0; k < fault.count; ++k) ++later, add();
  }
  return held;
}

// Leaves out frames after the blackout until the vehicle has come as far as asked for, and closes
// the gap in the stamps.
void Kidnap(const DataFault& fault, const Recording& recording, std::vector<Delivery>* all) {
  const size_t back = fault.frames[0].last + 1;  // would come next
  TVL_CHECK_INPUT(recording.truth.size() == recording.size)
      << "fault kidnap: the true poses of this input are not known";
  size_t first = back;
  const auto away_m = [&](size_t frame) {
    return (recording.truth[frame].t() - recording.truth[back].t()).norm();
  };
  while (first < recording.size && away_m(first) < fault.metres) ++first;
  TVL_CHECK_INPUT(first < recording.size)
      << "fault kidnap: the drive does not come " << fault.metres << " m away from frame " << back;
  const auto after = [&](size_t frame) {
    return std::find_if(all->begin(), all->end(),
                        [&](const Delivery& d) { return d.source >= frame; });
  };
  const auto expected = after(back), seen = after(first);
  TVL_CHECK_INPUT(seen != all->end()) << "fault kidnap: no frame is left after it";
  const int64_t time_ns = seen->stamp.ns - expected->stamp.ns;
  for (auto d = seen; d != all->end(); ++d) d->stamp.ns -= time_ns;
  all->erase(expected, seen);
}

void Blacken(const std::vector<Range>& frames, std::vector<Delivery>* all) {
  for (Delivery& d : *all) d.is_blank = d.is_blank || IsIn(frames, d.source);
}

void CheckFault(const DataFault& fault, const Recording& recording) {
  const std::string name = FormOf(fault.kind).name;
  const std::string wanted = FormOf(fault.kind).arguments;
  const bool wants_frames = wanted.find_first_of("fr*") != std::string::npos;
  TVL_CHECK_INPUT(!wants_frames || !fault.frames.empty()) << "fault " << name << ": which frames?";
  for (const Range& range : fault.frames) {
    TVL_CHECK_INPUT(range.last < recording.size && range.first <= range.last)
        << "fault " << name << ": frames " << range.first << "-" << range.last << " of "
        << recording.size;
  }
  TVL_CHECK_INPUT(wanted.find('n') == std::string::npos || fault.count >= 1)
      << "fault " << name << ": the count must be at least 1";
  const bool is_sized = fault.kind == Kind::kRound || fault.kind == Kind::kJitter;
  TVL_CHECK_INPUT(std::isfinite(fault.seconds) && (!is_sized || fault.seconds > 0.0))
      << "fault " << name << ": a time of " << fault.seconds << " s";
  TVL_CHECK_INPUT(std::isfinite(fault.metres) && fault.metres >= 0.0)
      << "fault " << name << ": a distance of " << fault.metres << " m";
}

void Apply(const DataFault& fault, const Recording& recording, std::vector<Delivery>* all) {
  CheckFault(fault, recording);
  switch (fault.kind) {
    case Kind::kDrop:
      Remove([&](const Delivery& d) { return IsIn(fault.frames, d.source); }, all);
      break;
    case Kind::kEvery:
      Remove([&](const Delivery& d) { return d.source % fault.count != 0; }, all);
      break;
    case Kind::kRepeat:
      *all = Repeated(*all, fault.count, recording.period_ns);
      break;
    case Kind::kHold:
      *all = Held(*all, fault, recording.period_ns);
      break;
    case Kind::kBlackout:
      Blacken(fault.frames, all);
      break;
    case Kind::kKidnap:
      Blacken(fault.frames, all);
      Kidnap(fault, recording, all);
      break;
    default:
      ShiftStamps(fault, recording, all);
  }
  TVL_CHECK_INPUT(!all->empty()) << "fault " << FormOf(fault.kind).name << ": no frame is left";
}

}  // namespace

std::vector<DataFault> ParseFaults(const std::string& text) {
  std::vector<DataFault> faults;
  for (const std::string& part : Split(text, ';')) faults.push_back(ParseFault(part));
  return faults;
}

FaultyDataset::FaultyDataset(std::unique_ptr<const Dataset> dataset,
                             const std::vector<DataFault>& faults)
    : dataset_(std::move(dataset)) {
  for (size_t i = 0; i < dataset_->size(); ++i) {
    deliveries_.push_back({i, dataset_->Stamp(i), false});
  }
  const Recording recording{dataset_->size(), NominalPeriod_ns(deliveries_),
                            dataset_->Truth_T_first_cam0()};
  for (const DataFault& fault : faults) Apply(fault, recording, &deliveries_);
}

SensorFrame FaultyDataset::Frame(size_t index) const {
  TVL_CHECK(index < size()) << "frame " << index << " of " << size();
  const Delivery& delivery = deliveries_[index];
  const std::string name = "frame " + std::to_string(index);
  SensorFrame frame;
  if (delivery.is_blank) {
    frame.faults.push_back({FrameFault::Kind::kEmptyScan, name + ": no points (blackout)"});
    if (setup().has_camera) {
      frame.faults.push_back({FrameFault::Kind::kBlackImage, name + ": black (blackout)"});
    }
  } else {
    frame = dataset_->Frame(delivery.source);
  }
  frame.id = static_cast<FrameId>(index), frame.stamp = delivery.stamp;
  const auto is_of_time = [](const FrameFault& fault) {
    return fault.kind == FrameFault::Kind::kTimeNotIncreasing;
  };
  frame.faults.erase(std::remove_if(frame.faults.begin(), frame.faults.end(), is_of_time),
                     frame.faults.end());
  if (index > 0 && delivery.stamp <= deliveries_[index - 1].stamp) {
    frame.faults.push_back({FrameFault::Kind::kTimeNotIncreasing,
                            name + ": its time " + std::to_string(delivery.stamp.seconds()) +
                                " s is not after that of the frame before"});
  }
  return frame;
}

std::vector<Rigid3d> FaultyDataset::Truth_T_first_cam0() const {
  const std::vector<Rigid3d> good = dataset_->Truth_T_first_cam0();
  if (good.size() != dataset_->size()) return {};
  const Rigid3d T_first_good = good[deliveries_.front().source].Inverse();
  std::vector<Rigid3d> truth;
  for (const Delivery& delivery : deliveries_)
    truth.push_back(T_first_good * good[delivery.source]);
  truth.front() = Rigid3d();
  return truth;
}

}  // namespace tvl
