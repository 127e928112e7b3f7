#include "tvl/sim/texture.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/rng.h"
#include "tvl/sim/texture_patterns.h"

namespace tvl::sim {
namespace {

int Cell(float x, float size) {
  const float cell = x / size;
  const int i = static_cast<int>(cell);
  return i - static_cast<int>(cell < static_cast<float>(i));
}

// Far from the origin a trace of noise in the normal would move a texture along the wall: places
// are taken relative to the nearest node of a coarse grid. Houses and cars lie around node 0.
float Local(float x) {
  constexpr float kNodes_m = 8.0F * kPatternPeriod_m;
  return x - kNodes_m * static_cast<float>(Cell(x + 0.5F * kNodes_m, kNodes_m));
}

// Coordinates on a surface from its normal: x, y on flat ground; along and up on walls and roofs.
TextureFootprint OnSurface(const SurfacePoint& at) {
  const Eigen::Vector3f& n = at.normal_object;
  const Eigen::Vector3f& p = at.p_object;
  if (std::abs(n.z()) > 0.75F) {
    return {p.x(), p.y(), at.major_m.x(), at.major_m.y(), at.minor_m};
  }
  const float h = std::sqrt(n.x() * n.x() + n.y() * n.y());
  const float tx = -n.y() / h;
  const float ty = n.x() / h;
  return {tx * Local(p.x()) + ty * Local(p.y()), Local(p.z()) / h,
          tx * at.major_m.x() + ty * at.major_m.y(), at.major_m.z() / h, at.minor_m};
}

// Coordinates that do not depend on the normal: for small curved things such as kerb stones.
TextureFootprint Sheared(const SurfacePoint& at) {
  const Eigen::Vector3f& p = at.p_object;
  const Eigen::Vector3f& m = at.major_m;
  return {p.x() + 0.7F * p.z(), p.y() + 0.4F * p.z(), m.x() + 0.7F * m.z(), m.y() + 0.4F * m.z(),
          at.minor_m};
}

void Shift(TextureFootprint& at, float share_u, float share_v) {
  at.u_m += share_u * kPatternPeriod_m;
  at.v_m += share_v * kPatternPeriod_m;
}

float Extent(const TextureFootprint& at) {
  return std::max(at.minor_m, std::abs(at.major_u_m) + std::abs(at.major_v_m));
}

// Share of a footprint of length `width` around `x` that lies above `edge`: an anti-aliased step.
float Above(float x, float edge, float width) {
  return std::clamp((x - edge) / std::max(width, 1e-4F) + 0.5F, 0.0F, 1.0F);
}

// Share of the footprint within [low, high].
float Within(float x, float low, float high, float width) {
  return std::max(0.0F, Above(x, low, width) - Above(x, high, width));
}

float Mix(float a, float b, float share) { return a + share * (b - a); }

// Scales a base by a pattern around 0.5.
float Modulate(float base, float pattern, float contrast) {
  return base * std::max(0.05F, 1.0F + 2.0F * contrast * (pattern - 0.5F));
}

float ToUnit(uint64_t hash) { return static_cast<float>(hash >> 40) * 0x1.0p-24F; }

// 1 where one of the bars of `width` at every `period` lies, 0 between, anti-aliased; its mean
// where the footprint spans the period.
float Bars(float x, float period, float width, float footprint) {
  if (footprint > 0.7F * period) return width / period;
  const float in = x - std::floor(x / period) * period;
  return std::min(
      1.0F, Within(in, 0.0F, width, footprint) + Within(in, period, period + width, footprint));
}

bool IsOfHouse(Material material) {
  return material == Material::kPlaster || material == Material::kBrick ||
         material == Material::kConcrete || material == Material::kWindowGlass ||
         material == Material::kWindowFrame || material == Material::kDoor ||
         material == Material::kRoof;
}

}  // namespace

TownTextures::TownTextures(const TextureOptions& options)
    : seed_(options.seed),
      has_identical_houses_(options.has_identical_houses),
      noise_(PaintNoise(seed_ + 1, 0.3), kPatternPeriod_m),
      asphalt_(PaintAsphalt(seed_ + 2), kPatternPeriod_m),
      bricks_(PaintBricks(seed_ + 3), kPatternPeriod_m),
      plaster_(PaintPlaster(seed_ + 4), kPatternPeriod_m),
      leaves_(PaintLeaves(seed_ + 5), kPatternPeriod_m),
      grass_(PaintGrass(seed_ + 6), kPatternPeriod_m),
      slabs_(PaintSlabs(seed_ + 7), kPatternPeriod_m),
      roof_tiles_(PaintRoofTiles(seed_ + 8), kPatternPeriod_m),
      lining_(PaintTunnelLining(seed_ + 9), kPatternPeriod_m) {}

float TownTextures::OfObject(uint32_t object, uint32_t what) const {
  return ToUnit(Rng::Mix(seed_ ^ (static_cast<uint64_t>(object) * 0x9e3779b97f4a7c15ULL + what)));
}

float TownTextures::OfCell(int x, int y, uint32_t what) const {
  const auto key = (static_cast<uint64_t>(static_cast<uint32_t>(x)) << 32) ^
                   (static_cast<uint64_t>(static_cast<uint32_t>(y)) + (uint64_t{what} << 27));
  return ToUnit(Rng::Mix(seed_ ^ Rng::Mix(key)));
}

float TownTextures::Albedo(const SurfacePoint& at) const {
  if (!has_identical_houses_ || !IsOfHouse(at.material)) return AlbedoOf(at);
  SurfacePoint same = at;
  same.object = 0;
  return AlbedoOf(same);
}

// Of what is driven, walked or looked down on.
float TownTextures::GroundAlbedo(const SurfacePoint& at) const {
  switch (at.material) {
    case Material::kRoadMarking:
      return RoadMarking(at);
    case Material::kPavement:
      return Ground(at, slabs_, 0.38F, 0.9F);
    case Material::kKerb:
      return Kerb(at);
    case Material::kGrass:
      return Ground(at, grass_, 0.30F, 1.0F);
    case Material::kSoil:
      return Ground(at, asphalt_, 0.22F, 0.9F);
    case Material::kRichAsphalt:
      return RichAsphalt(at);
    case Material::kSmoothAsphalt:
      return PlainAsphalt(at, 0.28F, 0.1F);
    case Material::kWetAsphalt:
      return PlainAsphalt(at, 0.12F, 0.15F);
    default:
      return Asphalt(at, true);
  }
}

float TownTextures::AlbedoOf(const SurfacePoint& at) const {
  switch (at.material) {
    case Material::kAsphalt:
    case Material::kRoadMarking:
    case Material::kPavement:
    case Material::kKerb:
    case Material::kGrass:
    case Material::kSoil:
    case Material::kRichAsphalt:
    case Material::kSmoothAsphalt:
    case Material::kWetAsphalt:
      return GroundAlbedo(at);
    case Material::kPlaster:
      return Facade(at, plaster_, 0.30F + 0.5F * OfObject(at.object, 1), 0.65F);
    case Material::kBrick:
      return Facade(at, bricks_, 0.18F + 0.15F * OfObject(at.object, 1), 0.9F);
    case Material::kConcrete:
      return Facade(at, plaster_, 0.32F, 1.2F);
    case Material::kWindowGlass:
      return WindowGlass(at);
    case Material::kWindowFrame:
    case Material::kDoor:
    case Material::kMetal:
    case Material::kTyre:
    case Material::kSkin:
      return Painted(at);
    case Material::kRoof:
      return Facade(at, roof_tiles_, 0.10F + 0.16F * OfObject(at.object, 2), 0.8F);
    case Material::kWood:
      return Wood(at);
    case Material::kSign:
      return Sign(at);
    case Material::kBark:
      return Bark(at);
    case Material::kFoliage:
      return Foliage(at);
    case Material::kCarPaint:
      return CarPaint(at);
    case Material::kCarGlass:
      return CarGlass(at);
    case Material::kCarTrim:
      return CarTrim(at);
    case Material::kClothing:
      return Clothing(at);
    case Material::kTunnelWall:
      return TunnelWall(at);
    case Material::kTunnelFixture:
      return 1.0F;
    case Material::kTarpaulin:
      return Tarpaulin(at);
    case Material::kCount:
      break;
  }
  return 0.5F;
}

// Rectangular repairs of another tone and manhole covers lie in cells of 7 m.
float TownTextures::Asphalt(const SurfacePoint& at, bool has_lids) const {
  const TextureFootprint f = OnSurface(at);
  float base = Modulate(0.32F, noise_.Sample(f.u_m / 9.0F, f.v_m / 9.0F, Extent(f) / 9.0F), 0.2F);
  constexpr float kCell_m = 7.0F;
  const int cx = Cell(f.u_m, kCell_m);
  const int cy = Cell(f.v_m, kCell_m);
  const float x = f.u_m - static_cast<float>(cx) * kCell_m - 0.5F * kCell_m;
  const float y = f.v_m - static_cast<float>(cy) * kCell_m - 0.5F * kCell_m;
  const float half_x = 0.3F + 3.0F * OfCell(cx, cy, 1);
  const float half_y = 0.3F + 2.0F * OfCell(cx, cy, 2);
  const float wx = std::max(f.minor_m, std::abs(f.major_u_m));
  const float wy = std::max(f.minor_m, std::abs(f.major_v_m));
  const float pick = OfCell(cx, cy, 3);
  if (pick < 0.45F) {
    const float patch = Within(x, -half_x, half_x, wx) * Within(y, -half_y, half_y, wy);
    base *= Mix(1.0F, 0.6F + 0.75F * OfCell(cx, cy, 4), patch);
  } else if (has_lids && pick < 0.65F) {
    const float r = std::sqrt(x * x + y * y);
    const float lid = Above(-r, -0.34F, Extent(f));
    const float ring = lid * Within(r, 0.24F, 0.29F, Extent(f));
    base *= Mix(1.0F, 0.55F, lid) * Mix(1.0F, 1.8F, ring);
  }
  return Modulate(base, asphalt_.Sample(f), 0.75F);
}

// Cracks sealed with tar run where two slowly varying fields have their middle values.
float TownTextures::RichAsphalt(const SurfacePoint& at) const {
  const TextureFootprint f = OnSurface(at);
  constexpr float kStretch = 3.0F;  // of the pattern: cracks some metres apart
  const float width = 0.012F + 0.05F * Extent(f);
  float seal = 0.0F;
  for (const float shift : {0.0F, 0.37F}) {
    TextureFootprint g = f;
    Shift(g, shift, shift);
    const float field =
        noise_.Sample(g.u_m / kStretch, g.v_m / (2.0F * kStretch), Extent(f) / kStretch);
    seal = std::max(seal, 1.0F - std::abs(field - 0.5F) / width);
  }
  const float visible = Above(-Extent(f), -0.4F, 0.4F);
  return Asphalt(at, false) * (1.0F - 0.6F * std::clamp(seal, 0.0F, 1.0F) * visible);
}

float TownTextures::PlainAsphalt(const SurfacePoint& at, float base, float contrast) const {
  return Modulate(base, asphalt_.Sample(OnSurface(at)), contrast);
}

float TownTextures::RoadMarking(const SurfacePoint& at) const {
  const TextureFootprint f = OnSurface(at);
  const float wear = Above(noise_.SampleScaled(f, 2.0F, 2.0F), 0.22F, 0.1F + Extent(f));
  return Modulate(Mix(0.3F, 0.75F, wear), asphalt_.Sample(f), 0.4F);
}

float TownTextures::Ground(const SurfacePoint& at, const TextureTile& tile, float base,
                           float contrast) const {
  const TextureFootprint f = OnSurface(at);
  const float coarse = noise_.Sample(f.u_m / 7.0F, f.v_m / 7.0F, Extent(f) / 7.0F);
  return Modulate(Modulate(base, coarse, 0.4F), tile.Sample(f), contrast);
}

float TownTextures::Kerb(const SurfacePoint& at) const {
  const TextureFootprint f = Sheared(at);
  return Modulate(Modulate(0.45F, asphalt_.Sample(f), 0.7F), slabs_.SampleScaled(f, 0.4F, 0.4F),
                  0.5F);
}

// The tile shifted by object, slow stains, splash water along the foot.
float TownTextures::Facade(const SurfacePoint& at, const TextureTile& tile, float base,
                           float contrast) const {
  TextureFootprint f = OnSurface(at);
  const float foot = Above(-at.p_object.z(), -0.5F, 0.6F + at.minor_m);
  Shift(f, OfObject(at.object, 5), 0.0F);
  const float coarse = noise_.Sample(f.u_m / 5.0F, f.v_m / 5.0F, Extent(f) / 5.0F);
  return Modulate(Modulate(base, coarse, 0.15F), tile.Sample(f), contrast) * (1.0F - 0.25F * foot);
}

// Dark rooms, curtains in some, light bars across.
float TownTextures::WindowGlass(const SurfacePoint& at) const {
  const TextureFootprint f = OnSurface(at);
  const int cx = Cell(f.u_m, 1.3F);
  const int cy = Cell(f.v_m, 2.8F);
  const auto what = at.object * 8U;
  float tone = Modulate(0.06F, noise_.SampleScaled(f, 1.5F, 1.5F), 1.0F);
  const float kind = OfCell(cx, cy, what + 1);
  if (kind < 0.45F) {  // curtains, in folds
    const float folds = Bars(f.u_m, 0.11F, 0.05F, std::abs(f.major_u_m) + f.minor_m);
    tone = Mix(0.16F, 0.32F, folds) * (0.5F + OfCell(cx, cy, what + 2));
  } else if (kind < 0.6F) {  // blinds
    tone = Mix(0.2F, 0.45F, Bars(f.v_m, 0.07F, 0.045F, std::abs(f.major_v_m) + f.minor_m));
  }
  const float bars = std::max(Bars(f.u_m, 0.62F, 0.05F, std::abs(f.major_u_m) + f.minor_m),
                              Bars(f.v_m, 0.93F, 0.05F, std::abs(f.major_v_m) + f.minor_m));
  return Mix(tone, 0.6F, bars);
}

float TownTextures::Painted(const SurfacePoint& at) const {
  const TextureFootprint f = OnSurface(at);
  const float random = OfObject(at.object, 7);
  float base = 0.55F + 0.3F * random;
  if (at.material == Material::kDoor) base = 0.08F + 0.4F * random * random;
  if (at.material == Material::kMetal) base = 0.12F + 0.45F * random;
  if (at.material == Material::kTyre) base = 0.03F;
  if (at.material == Material::kSkin) base = 0.4F;
  if (at.material == Material::kDoor) {
    const float panel = Bars(f.u_m, 0.45F, 0.05F, std::abs(f.major_u_m) + f.minor_m);
    base *= 1.0F - 0.5F * std::max(panel, Bars(f.v_m, 0.8F, 0.05F, std::abs(f.major_v_m)));
  }
  return Modulate(base, plaster_.SampleScaled(f, 1.3F, 1.3F), 0.9F);
}

float TownTextures::Wood(const SurfacePoint& at) const {
  TextureFootprint f = OnSurface(at);
  const int plank = Cell(f.u_m, 0.12F);
  const float gap = Bars(f.u_m, 0.12F, 0.012F, std::abs(f.major_u_m) + f.minor_m);
  const float tone =
      Mix(0.75F, 0.5F + 0.5F * OfCell(plank, 0, at.object), Above(-f.minor_m, -0.1F, 0.1F));
  Shift(f, 0.0F, OfCell(plank, 1, at.object));
  const float grain = noise_.SampleScaled(f, 2.0F, 0.25F);
  return Modulate(0.28F * tone, grain, 0.7F) * (1.0F - 0.7F * gap);
}

// Lines of dark letters on white; from afar their average.
float TownTextures::Sign(const SurfacePoint& at) const {
  const TextureFootprint f = OnSurface(at);
  constexpr float kLine_m = 0.21F;
  constexpr float kLetter_m = 0.065F;
  const int line = Cell(f.v_m, kLine_m);
  const float in_line = f.v_m - kLine_m * static_cast<float>(line);
  const float width = Extent(f);
  const bool dark = OfCell(Cell(f.u_m, kLetter_m), line, at.object) < 0.6F;
  const float ink = dark ? Within(in_line, 0.04F, 0.17F, width) : 0.0F;
  const float crisp = Above(-width, -kLetter_m, kLetter_m);
  return Mix(0.8F, 0.08F, Mix(0.37F, ink, crisp));
}

float TownTextures::Bark(const SurfacePoint& at) const {
  TextureFootprint f = OnSurface(at);
  Shift(f, OfObject(at.object, 8), 0.3F * at.normal_object.x());
  return Modulate(0.13F, noise_.SampleScaled(f, 4.0F, 1.0F), 1.6F);
}

// Each card of leaves gets its own tone: its direction is as good as a name.
float TownTextures::Foliage(const SurfacePoint& at) const {
  TextureFootprint f = Sheared(at);
  const Eigen::Vector3f n = at.normal_object * 512.0F;
  const float card =
      OfCell(static_cast<int>(std::abs(n.x())), static_cast<int>(std::abs(n.y())), at.object);
  Shift(f, card, 7.3F * card - std::floor(7.3F * card));
  const float tone = (0.7F + 0.6F * card) * (0.8F + 0.4F * OfObject(at.object, 9));
  return std::min(0.7F, 0.04F + 0.85F * tone * leaves_.Sample(f));
}

// Panel gaps and a moulding, mud at the bottom.
float TownTextures::CarPaint(const SurfacePoint& at) const {
  const TextureFootprint f = OnSurface(at);
  const float random = OfObject(at.object, 10);
  constexpr float kTones[] = {0.05F, 0.08F, 0.14F, 0.22F, 0.35F, 0.45F, 0.55F, 0.75F};
  const float base = kTones[std::min(7, static_cast<int>(random * 8.0F))];
  const float side = std::abs(at.normal_object.y());
  const float gap = side > 0.6F ? Bars(at.p_object.x() + 10.4F, 1.05F, 0.012F,
                                       std::abs(at.major_m.x()) + at.minor_m)
                                : 0.0F;
  const float mud = Above(-at.p_object.z(), -0.35F, 0.3F);
  const float moulding =
      Within(at.p_object.z(), 0.52F, 0.57F, std::abs(at.major_m.z()) + at.minor_m);
  const float tone = Modulate(base, noise_.SampleScaled(f, 1.0F, 1.0F), 0.25F);
  return Mix(tone, 0.02F, std::max(gap, 0.8F * moulding)) * (1.0F - 0.4F * mud);
}

// Seats and head rests behind the glass.
float TownTextures::CarGlass(const SurfacePoint& at) const {
  const TextureFootprint f = OnSurface(at);
  const float seat = Bars(f.u_m + 0.3F, 0.65F, 0.28F, Extent(f));
  const float low = Above(-at.p_object.z(), -1.2F, 0.05F + at.minor_m);
  return 0.03F + 0.07F * seat * low + 0.03F * noise_.SampleScaled(f, 2.0F, 2.0F);
}

// Plates, grilles, lamps: light and dark blocks of a hand's width.
float TownTextures::CarTrim(const SurfacePoint& at) const {
  const TextureFootprint f = OnSurface(at);
  const float block = OfCell(Cell(f.u_m, 0.09F), Cell(f.v_m, 0.06F), at.object);
  const float plate = Within(std::abs(at.p_object.y()), -0.3F, 0.26F, at.minor_m) *
                      Within(at.p_object.z(), 0.30F, 0.41F, at.minor_m);
  const float letters = Bars(f.u_m, 0.06F, 0.03F, Extent(f));
  const float trim = 0.05F + (block > 0.94F ? 0.22F * Above(-Extent(f), -0.08F, 0.1F) : 0.0F);
  return Mix(trim, Mix(0.8F, 0.08F, letters), plate);
}

float TownTextures::Clothing(const SurfacePoint& at) const {
  const TextureFootprint f = OnSurface(at);
  const float upper = Above(at.p_object.z(), 0.9F, 0.03F + at.minor_m);
  const float tone =
      Mix(0.06F + 0.25F * OfObject(at.object, 11), 0.08F + 0.7F * OfObject(at.object, 12), upper);
  return Modulate(tone, noise_.SampleScaled(f, 2.0F, 2.0F), 1.0F);
}

// Folds, and a line of letters half a metre wide made of blocks; from afar their average.
float TownTextures::Tarpaulin(const SurfacePoint& at) const {
  const TextureFootprint f = OnSurface(at);
  const float random = OfObject(at.object, 13);
  const float base = 0.15F + 0.5F * random;
  constexpr float kLetter_m = 0.55F, kBlock_m = 0.14F, kLow_m = 2.1F, kHigh_m = 2.95F;
  const float x = at.p_object.x(), z = at.p_object.z();
  const float width = Extent(f);
  const int letter = Cell(x, kLetter_m);
  const bool is_drawn = OfCell(letter, 0, at.object * 4U + 1) < 0.7F;
  const bool is_ink = OfCell(Cell(x, kBlock_m), Cell(z, 0.2F), at.object * 4U + 2) < 0.55F;
  const float in_line = Within(z, kLow_m, kHigh_m, width);
  const float crisp = Above(-width, -kBlock_m, kBlock_m);
  const float ink = in_line * (is_drawn ? Mix(0.55F, is_ink ? 1.0F : 0.0F, crisp) : 0.0F);
  const float fold = Bars(x, 1.15F, 0.04F, std::abs(at.major_m.x()) + at.minor_m);
  const float cloth = Modulate(base, noise_.SampleScaled(f, 1.5F, 1.5F), 0.25F);
  return Mix(cloth * (1.0F - 0.35F * fold), base > 0.4F ? 0.07F : 0.7F, ink);
}

// Panels of one period each show another part of the lining, so that no sign comes twice in sight.
float TownTextures::TunnelWall(const SurfacePoint& at) const {
  TextureFootprint f = OnSurface(at);
  const int panel = Cell(f.u_m, kPatternPeriod_m);
  const float joint = Bars(f.u_m + 0.02F, kPatternPeriod_m, 0.04F, std::abs(f.major_u_m));
  Shift(f, OfCell(panel, 0, 1), OfCell(panel, 0, 2));
  const float fine = lining_.Sample(f);
  const float coarse = lining_.SampleScaled(f, 0.23F, 0.23F);
  const float albedo = 0.05F + 0.75F * fine * (0.35F + 1.1F * coarse);
  return std::clamp(albedo * (1.0F - 0.7F * joint), 0.02F, 0.9F);
}

}  // namespace tvl::sim
