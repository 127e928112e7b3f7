// A recording as it should not be, made from a good one: frames lost, repeated or late, clocks that
// jump, cameras and lidars that see nothing. For tests of what happens then.
//
//   FaultyDataset lost(OpenInput("sim:city?seed=3"), ParseFaults("drop:30-32;renumber"));
//
// As text, faults are joined by ';' and applied in the order given; each is NAME or NAME:ARGUMENTS.
// Frames are numbered as in the good recording, whatever was done before; A-B includes both ends.
// The ids of what is delivered count from 0 without gaps, as those of any input do.
// Where times are stamped:
//
//   late:K,S          the stamp of frame K is S seconds late (negative: early)
//   odd:S             so is that of every second frame delivered
//   jitter:SIGMA      every stamp has a normal error, s; jitter:SIGMA,SEED for another draw
//   round:S           stamps are rounded to multiples of S
//   clock:K,S         from frame K on the clock is S seconds ahead
//   equal             all stamps are that of the first frame
//
// Where frames are lost or come again:
//
//   drop:30-32,40     not delivered; the stamps of the others stay right
//   every:N           only frames 0, N, 2 N, ... are delivered
//   repeat:N          every frame N times in place of once, evenly in the time to the next: a slow
//                     lidar listed at the rate of a fast camera
//   hold:K,N          frame K is delivered N times more; all later ones come N periods later
//   renumber          stamps run on regularly at the nominal period, from the first on: after
//                     others, so that nothing tells of what is missing or too many
//
// Where nothing is seen:
//
//   blackout:A-B      images are black and scans empty (frames without image and scan, with the
//                     faults of such files)
//   kidnap:A-B,D      the same; then frames are left out and those after them follow at once, so
//                     that the vehicle reappears D metres from where it was expected; needs truth
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tvl/sensor/dataset.h"

namespace tvl {

struct DataFault {
  enum class Kind {
    kLate,
    kOddLate,
    kJitter,
    kRound,
    kClockStep,
    kEqual,
    kDrop,
    kEvery,
    kRepeat,
    kHold,
    kRenumber,
    kBlackout,
    kKidnap,
  };
  struct Range {
    size_t first = 0, last = 0;  // both included
  };
  Kind kind = Kind::kRenumber;
  std::vector<Range> frames;  // kDrop: any; one of kLate, kClockStep, kHold, kBlackout, kKidnap
  size_t count = 0;           // N of kEvery, kRepeat, kHold
  double seconds = 0.0;       // S, or SIGMA of kJitter
  double metres = 0.0;        // D of kKidnap
  uint64_t seed = 1;          // of kJitter
};

// Throws InputError naming the fault that cannot be understood. Empty text: no faults.
std::vector<DataFault> ParseFaults(const std::string& text);

// A Dataset with faults. Truth stays with the frames delivered, in the frame of the first of them.
// Faults of the frames themselves stay; where stamps do not increase, that is said as a folder
// would (kTimeNotIncreasing). Const and thread-safe if the dataset is.
class FaultyDataset : public Dataset {
 public:
  // Throws InputError for frames that the dataset does not have, for kKidnap without truth, and
  // when no frame is left.
  FaultyDataset(std::unique_ptr<const Dataset> dataset, const std::vector<DataFault>& faults);

  const SensorSetup& setup() const override { return dataset_->setup(); }
  size_t size() const override { return deliveries_.size(); }
  SensorFrame Frame(size_t index) const override;
  Timestamp Stamp(size_t index) const override { return deliveries_.at(index).stamp; }
  std::vector<Rigid3d> Truth_T_first_cam0() const override;

  // Which frame of the good recording is delivered as frame `index`.
  size_t SourceOf(size_t index) const { return deliveries_.at(index).source; }

  // What is delivered instead of one frame.
  struct Delivery {
    size_t source = 0;  // frame of the good recording
    Timestamp stamp;
    bool is_blank = false;  // neither image nor scan
  };

 private:
  std::unique_ptr<const Dataset> dataset_;
  std::vector<Delivery> deliveries_;
};

}  // namespace tvl
