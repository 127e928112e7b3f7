// Loops suspected because the surroundings look alike to the lidar (beyond the paper).
#pragma once

#include <vector>

#include "tvl/loop/drift_model.h"
#include "tvl/loop/lidar_descriptor.h"
#include "tvl/loop/loop_separation.h"
#include "tvl/map/loop.h"

namespace tvl {

struct LidarProposerOptions {
  // Places whose signature is closest are compared image by image, 0.2 ms each.
  int shortlist = 10;
  // Neighbours on the shortlist are this many keyframes apart: they show the same.
  int shortlist_gap = 3;
  // The lanes of a street are 2-5 m apart.
  double max_offset_m = 12.0;
  // Normalised correlation of the images, 0..1.
  double min_similarity = 0.5;
  // Matches that fit nearly as well elsewhere (PlaceMatch::ambiguity) are handed on as kYaw, the
  // shift along the street to be searched for, others as kPose. On a hedge-lined street wrong
  // shifts have 0.96 and more; among houses 99 % of the right ones are below 0.9.
  double max_ambiguity = 0.9;
  // Proposals a keyframe, each of another pass over the place (or another place).
  int max_proposals = 2;
  void Check() const;
};

// Holds the descriptors of all keyframes (6.7 kB each), in their order. Not thread-safe.
class LidarProposer {
 public:
  LidarProposer(const LidarDescriptorOptions& descriptor, const LidarProposerOptions& options);

  // The next keyframe's. Without a scan: a LidarDescriptor as constructed, which is never proposed.
  void Add(LidarDescriptor descriptor);
  int size() const { return static_cast<int>(descriptors_.size()); }
  const LidarDescriptor& descriptor(int keyframe) const;

  // Proposals for `current`, best first: guess kPose or kYaw with z, roll and pitch as on one
  // level road, score the similarity. History keyframes are eligible by `separation` and lie, by
  // the present estimate, within `radius` of their linked path (LinkedPath of `current`). About 2
  // ms at 4,500 keyframes. Throws Error for a keyframe without a descriptor.
  std::vector<LoopProposal> Propose(const KeyframeTrack& track, int current,
                                    const std::vector<double>& linked_path_m,
                                    const DriftRadius& radius,
                                    const LoopSeparationOptions& separation) const;

 private:
  std::vector<int> Shortlist(const KeyframeTrack& track, int current, int eligible,
                             const std::vector<double>& linked_path_m,
                             const DriftRadius& radius) const;

  LidarDescriptorOptions descriptor_options_;
  LidarProposerOptions options_;
  std::vector<LidarDescriptor> descriptors_;
};

}  // namespace tvl
