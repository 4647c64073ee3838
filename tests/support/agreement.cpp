// SPDX-License-Identifier: Apache-2.0
#include "support/agreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "data/lattice/resident_lattice.h"
#include "ovoid/devices.h"
#include "support/compare.h"
#include "support/scenes.h"
#include "support/where.h"
#include "view/plan/frame_plan.h"

namespace ovoid::test {
namespace {

template <class T>
Bytes stored_numbers(const Index3& dims, const VolumeFunction& shape, const StoredRange& stored) {
  auto numbers = std::make_shared<std::vector<T>>();
  numbers->reserve(static_cast<std::size_t>(num_samples(dims)));
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const double number = stored.lo + shape(i, j, k) * (stored.hi - stored.lo);
        numbers->push_back(static_cast<T>(std::is_integral_v<T> ? std::round(number) : number));
      }
    }
  }
  return {numbers, std::as_bytes(std::span<const T>(*numbers))};
}

Bytes stored_bytes(const Index3& dims, const VolumeFunction& shape, const StoredRange& stored) {
  switch (stored.type) {
    case ScalarType::kUInt8:
      return stored_numbers<std::uint8_t>(dims, shape, stored);
    case ScalarType::kInt8:
      return stored_numbers<std::int8_t>(dims, shape, stored);
    case ScalarType::kUInt16:
      return stored_numbers<std::uint16_t>(dims, shape, stored);
    case ScalarType::kInt16:
      return stored_numbers<std::int16_t>(dims, shape, stored);
    default:
      return stored_numbers<float>(dims, shape, stored);
  }
}

// Missing samples one by one and a missing corner; the rest as `shape` says.
VolumeFunction with_holes(VolumeFunction shape) {
  return [shape = std::move(shape)](std::int64_t i, std::int64_t j, std::int64_t k) {
    const bool is_lone = (7 * i + 11 * j + 13 * k) % 29 == 0;
    const bool is_corner = i + j + k < 14;
    return is_lone || is_corner ? kMissing : shape(i, j, k);
  };
}

// A look of one opacity peak, 2 % of the range wide at its foot, and light.
Look peak_look(double lo, double hi, double place, double opacity) {
  const double span = hi - lo;
  Look look;
  look.transfer_function = color_map("viridis");
  look.transfer_function.map_range(lo, hi);
  look.transfer_function.opacities = {{lo, 0},
                                      {lo + (place - 0.01) * span, 0},
                                      {lo + place * span, opacity},
                                      {lo + (place + 0.01) * span, 0},
                                      {hi, 0}};
  return look;
}

std::int64_t num_pixels(const Image& image) {
  return static_cast<std::int64_t>(image.width) * image.height;
}

// Pixels whose depth is not the reference's: in one picture only, or farther apart than a
// thousandth of what is between two sheets.
std::int64_t num_other_depths(const std::vector<float>& actual, const std::vector<float>& expected,
                              double sheet_distance) {
  std::int64_t count = 0;
  for (std::size_t p = 0; p < actual.size(); ++p) {
    const auto a = static_cast<double>(actual[p]);
    const auto b = static_cast<double>(expected[p]);
    if (a != b && !(std::abs(a - b) <= 1e-3 * sheet_distance)) ++count;
  }
  return count;
}

// Pixels that are seen and have no front depth, or the other way round; all have the sizes of one
// picture.
std::int64_t num_unseen_fronts(const Image& image) {
  std::int64_t count = 0;
  for (std::size_t p = 0; p < image.front_depth.size(); ++p) {
    const bool is_seen = image.rgba[4 * p + 3] >= kLeastVisibleOpacity;
    if (is_seen != (image.front_depth[p] < std::numeric_limits<float>::infinity())) ++count;
  }
  return count;
}

// Where the back end to be tested has no device, nothing is.
class NeedsDevice final : public ::testing::Environment {
 public:
  void SetUp() override {
    if (tested_backend() != Backend::kVulkan) return;
    const VulkanSetup validating{.validates = true};
    const DeviceList list = list_devices(validating);
    const bool is_there = std::any_of(list.devices.begin(), list.devices.end(),
                                      [](const DeviceInfo& device) { return device.is_usable(); });
    if (!is_there) GTEST_SKIP() << "no Vulkan device: " << list.problem;
    // The first of the process, which all others share the layer with; never destroyed.
    static auto* const first =
        new Renderer(RendererSetup{.backend = Backend::kVulkan, .vulkan = validating});
    std::ignore = first;
  }
};
[[maybe_unused]] ::testing::Environment* const kNeedsDevice =
    ::testing::AddGlobalTestEnvironment(new NeedsDevice);

}  // namespace

LatticeField make_stored_field(const Index3& dims, const VolumeFunction& shape,
                               const StoredRange& stored, const FieldSetup& setup) {
  ResidentLatticeOptions options;
  const LatticeGeometry lattice{dims, setup.world_from_index, setup.lattice};
  options.range_reach = setup.kernel.support_radius() * lattice.unit_spacing();
  options.value_scale = setup.value_scale;
  options.value_offset = setup.value_offset;
  options.threads = 1;
  auto source = std::make_shared<ResidentLattice>(lattice, stored.type,
                                                  stored_bytes(dims, shape, stored), options);
  return LatticeField(std::move(source), setup.kernel, setup.reconstruction);
}

VolumeFunction shells(const Index3& dims) {
  return [dims](std::int64_t i, std::int64_t j, std::int64_t k) {
    const Vec3 half(0.5 * static_cast<double>(dims[0]), 0.5 * static_cast<double>(dims[1]),
                    0.5 * static_cast<double>(dims[2]));
    const Vec3 place =
        (Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)) -
         Vec3(0.45, 0.52, 0.47).cwiseProduct(2 * half))
            .cwiseQuotient(half);
    const double radius = place.cwiseProduct(Vec3(1.0, 1.2, 0.9)).norm();
    const double ripple = std::cos(2 * std::numbers::pi * 1.7 * radius + 2 * place.x());
    return 0.5 + 0.3 * ripple + 0.15 * std::sin(3 * place.y() + place.z());
  };
}

std::vector<TestVolume> test_volumes() {
  std::vector<TestVolume> volumes;
  const auto add = [&](const char* name, const Index3& dims, const StoredRange& stored,
                       const FieldSetup& setup, bool has_holes = false) {
    const VolumeFunction shape = has_holes ? with_holes(shells(dims)) : shells(dims);
    volumes.push_back({name, make_stored_field(dims, shape, stored, setup),
                       stored.lo * setup.value_scale + setup.value_offset,
                       stored.hi * setup.value_scale + setup.value_offset});
  };
  FieldSetup stretched;
  stretched.world_from_index = scaled_axes(Vec3(0.7, 1.0, 1.6), Vec3(-3, 20, 5));
  add("uint8", {34, 28, 20}, {ScalarType::kUInt8, 0, 255}, stretched);
  FieldSetup oblique;
  oblique.world_from_index = oblique_axes();
  oblique.value_scale = 0.25;
  oblique.value_offset = -100;
  add("int16 oblique", {25, 24, 27}, {ScalarType::kInt16, -1000, 3000}, oblique);
  add("float32 holes", {29, 28, 30}, {ScalarType::kFloat32, -2, 2}, {}, true);
  add("uint16 slice", {16, 16, 1}, {ScalarType::kUInt16, 0, 65535}, {});
  const VolumeFunction half = [](std::int64_t, std::int64_t, std::int64_t) { return 0.5; };
  volumes.push_back({"one sample", make_stored_field({1, 1, 1}, half, {}, {}), 0.0, 1.0});
  return volumes;
}

Look semi_transparent_look(double lo, double hi) {
  Look look;
  look.transfer_function = color_map("inferno");
  look.transfer_function.map_range(lo, hi);
  look.transfer_function.opacities = {{lo, 0.0, 0.4, 0.3}, {hi, 0.35}};
  return look;
}

std::vector<TestLook> test_looks(double lo, double hi) {
  const double span = hi - lo;
  Look opaque = semi_transparent_look(lo, hi);
  opaque.transfer_function.opacities = {{lo + 0.3 * span, 0.0}, {lo + 0.6 * span, 1.0}};
  Look stepped = semi_transparent_look(lo, hi);
  const double step = lo + 0.47 * span;
  stepped.transfer_function.colors = {
      {lo, {0.1, 0.2, 0.9}}, {step, {0.3, 0.9, 0.4}}, {step, {0.9, 0.1, 0.2}}, {hi, {1, 1, 0.6}}};
  return {{"peak", peak_look(lo, hi, 0.5, 0.9)},
          {"thin peak", peak_look(lo, hi, 0.503, 0.3)},
          {"opaque ramp", opaque},
          {"clear ramp", semi_transparent_look(lo, hi)},
          {"colour step", stepped}};
}

Camera askew_camera(const Field& field, bool is_parallel, double fill) {
  const Bounds3 bounds = field.world_bounds();
  const double half_height = 0.5 * bounds.diagonal().norm() / fill;
  const Vec3 direction(0.48, -0.31, 0.82);
  return is_parallel ? parallel_camera(bounds.center(), direction, half_height, 5 * half_height)
                     : perspective_camera(bounds.center(), direction, half_height, 4 * half_height);
}

const char* name_of(PostConvolution published) {
  if (published == PostConvolution::kBilinear) return "bilinear";
  return published == PostConvolution::kGaussian ? "gaussian" : "cubic";
}

std::shared_ptr<const DepthLimits> random_limits(const TestScene& scene, double reach) {
  std::mt19937 engine(23);  // NOLINT(bugprone-random-generator-seed): the same every time
  std::uniform_real_distribution<float> share(0, 1);
  const auto middle = static_cast<float>((scene.camera.focal_point - scene.camera.position).norm());
  auto limits = std::make_shared<DepthLimits>();
  limits->width = scene.options.width;
  limits->height = scene.options.height;
  limits->first.push_back(0);
  const int num_pixels = limits->width * limits->height;
  for (int pixel = 0; pixel < num_pixels; ++pixel) {
    const int count = pixel % 9;
    std::vector<float> depths;
    for (int i = 0; i < count; ++i)
      depths.push_back(middle + static_cast<float>(reach) * (2 * share(engine) - 1));
    std::sort(depths.begin(), depths.end());
    if (count > 0 && pixel % 2 == 0) depths[0] = -std::numeric_limits<float>::infinity();
    for (int i = 0; i < count; ++i) {
      DepthLimits::Stop stop{depths[static_cast<std::size_t>(i)], i % 3 != 1, {}};
      if (share(engine) < 0.5F) {
        const float opacity = share(engine) < 0.2F ? 1.0F : 0.5F * share(engine);
        stop.rgba = {opacity * share(engine), opacity * share(engine), opacity * share(engine),
                     opacity};
      }
      limits->stops.push_back(stop);
    }
    limits->first.push_back(static_cast<std::uint32_t>(limits->stops.size()));
    limits->coverage.push_back(pixel % 5 == 0 ? share(engine) : 1.0F);
  }
  return limits;
}

TestScene small_scene(Mode mode, bool is_parallel) {
  const Index3 dims{12, 11, 13};
  FieldSetup setup;
  setup.world_from_index = oblique_axes();
  TestScene scene;
  scene.field = make_stored_field(dims, shells(dims), {ScalarType::kFloat32, 10, 50}, setup);
  scene.camera = askew_camera(scene.field, is_parallel, 1.3);
  scene.look = semi_transparent_look(10, 50);
  scene.look.mode = mode;
  scene.look.isovalue = 32;
  scene.options = picture(24, 20);
  return scene;
}

Backend tested_backend() { return is_on_device() ? Backend::kVulkan : Backend::kCpu; }

bool is_on_graphics_processor() {
  if (tested_backend() != Backend::kVulkan) return false;
  const std::vector<DeviceInfo> devices = list_devices().devices;
  return std::any_of(devices.begin(), devices.end(),
                     [](const DeviceInfo& device) { return device.is_hardware(); });
}

bool is_left_out(int first, int second) {
  return tested_backend() == Backend::kVulkan && (first + second) % 2 != 0;
}

Scene TestScene::scene() const {
  Scene all(field, look);
  all.volumes.insert(all.volumes.end(), further.begin(), further.end());
  all.mixing = mixing;
  return all;
}

Scene with_trail(Scene scene, Trail trail) {
  scene.volumes.front().trail = std::make_shared<Trail>(std::move(trail));
  return scene;
}

Frame draw(const TestScene& scene, Backend backend) {
  if (backend == Backend::kVulkan) {
    // Never destroyed: drivers have ends of their own.
    static auto* const renderer = new Renderer(backend, 2);
    return renderer->render(scene.scene(), scene.camera, scene.options);
  }
  const char* const target = std::getenv("OVOID_TEST_TARGET");  // a SIMD target; none: the best
  Renderer renderer(
      {.backend = backend, .threads = 2, .simd_target = target == nullptr ? "" : target});
  return renderer.render(scene.scene(), scene.camera, scene.options);
}

::testing::AssertionResult agrees_with(const Image& reference, const TestScene& scene,
                                       const std::string& name, double least_covered,
                                       ImageTolerance tolerance) {
  return images_agree(draw(scene).image, reference, scene, name, least_covered, tolerance);
}

::testing::AssertionResult images_agree(const Image& image, const Image& reference,
                                        const TestScene& scene, const std::string& name,
                                        double least_covered, ImageTolerance tolerance) {
  if (scene.look.mode == Mode::kXray) {
    const double greatest = greatest_color(reference);
    tolerance.peak = greatest > 0 ? greatest : 1.0;
  }
  if (view::is_refined(scene.look, scene.options))
    tolerance.beyond_per_mille = kRefinedBeyondPerMille;
  const ImageDifference difference = compare(image, reference, tolerance.peak);
  const double apart = sheet_distance(scene.field, scene.look, scene.options);
  const std::int64_t other_depths = num_other_depths(image.depth, reference.depth, apart);
  const std::int64_t other_fronts =
      num_other_depths(image.front_depth, reference.front_depth, apart);
  std::printf("[agreement ] %-52s %6.1f dB, %d / 255, %4d covered, %d other depths\n", name.c_str(),
              difference.psnr_db, difference.max_8bit, static_cast<int>(difference.num_covered),
              static_cast<int>(other_depths));
  const auto pixels = static_cast<double>(num_pixels(reference));
  if (static_cast<double>(difference.num_covered) < least_covered * pixels) {
    return ::testing::AssertionFailure() << name << ": the picture shows too little";
  }
  if (static_cast<double>(other_depths) > kAgreementOtherDepths * pixels) {
    return ::testing::AssertionFailure() << name << ": " << other_depths << " other depths";
  }
  if (static_cast<double>(other_fronts) > kAgreementOtherFronts * pixels) {
    return ::testing::AssertionFailure() << name << ": " << other_fronts << " other front depths";
  }
  for (const Image* picture : {&image, &reference}) {
    if (const std::int64_t count = num_unseen_fronts(*picture); count > 0)
      return ::testing::AssertionFailure() << name << ": " << count << " fronts of what is unseen";
  }
  std::string file_name = name;
  for (char& c : file_name) {
    if (c == ' ' || c == '/') c = '_';
  }
  return agree(image, reference, file_name, tolerance);
}

::testing::AssertionResult backends_agree(const TestScene& scene, const std::string& name,
                                          double least_covered, ImageTolerance tolerance) {
  return agrees_with(draw(scene, Backend::kReference).image, scene, name, least_covered, tolerance);
}

void expect_agreement_however_evaluated(TestScene scene, const std::string& name,
                                        double least_covered) {
  const Image reference = draw(scene, Backend::kReference).image;
  for (const Evaluate evaluate : {Evaluate::kGather, Evaluate::kScatter, Evaluate::kAuto}) {
    scene.options.evaluate = evaluate;
    const char* way = evaluate == Evaluate::kGather    ? ", gather"
                      : evaluate == Evaluate::kScatter ? ", scatter"
                                                       : "";
    EXPECT_TRUE(agrees_with(reference, scene, name + way, least_covered));
  }
}

}  // namespace ovoid::test
