// The simulated camera: an 8-bit grey picture of a Scene, textured, lit by sun and sky, with the
// blur, exposure and noise of a real one. Design section 4.10.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "tvl/base/parallel.h"
#include "tvl/geometry/camera.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/sim/film.h"
#include "tvl/sim/lighting.h"
#include "tvl/sim/scene.h"
#include "tvl/sim/texture.h"

namespace tvl::sim {

struct CameraRenderOptions {
  uint64_t seed = 1;                  // of textures and noise
  bool has_identical_houses = false;  // to the last stain, see TextureOptions
  double max_range_m = 500.0;         // the sky begins there
  bool sun_shadows = true;            // cast hard shadows
  int edge_samples = 2;               // further rays through a pixel on an outline; 0: none
  LightingOptions lighting;
  FilmOptions film;  // its seed is mixed with `seed`
  // Throws InputError naming the field.
  void Check() const;
};

// One picture to take.
struct CameraShot {
  Rigid3d T_world_cam;
  double time_s = 0.0;  // where movers are: an instant, no motion blur
  uint64_t frame = 0;   // of the noise and the drift of the exposure
  bool night = false;   // almost black
};

// Immutable, thread-safe. The Scene must outlive it.
class CameraRenderer {
 public:
  // `camera` needs a size; distorted cameras give distorted pictures. Throws InputError for bad
  // options or a camera without size.
  CameraRenderer(const Scene& scene, const Camera& camera, const CameraRenderOptions& options = {});

  // CV_8U of the camera's size. The same for any number of threads.
  cv::Mat Render(const CameraShot& shot, const Executor& executor) const;

 private:
  const Scene& scene_;
  Camera camera_;
  CameraRenderOptions options_;
  TownTextures textures_;
  Lighting lighting_;
  Film film_;
  cv::Mat rays_;  // CV_32FC2: normalised image point of each pixel
};

}  // namespace tvl::sim
