// Shared meshes look as copies of them do. The copies are read from a glTF file that repeats the mesh: the same
// numbers, carried to the world in double.
#include <gtest/gtest.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/gtc/matrix_transform.hpp>

#include "simulator/render/motion.h"
#include "simulator/render/shading/surface.h"
#include "simulator/render/truth.h"
#include "tests/simulator/scene/gltf/placed_sheets.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

constexpr float kRounding = 0x1p-24f;

float largest(glm::vec3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

/// The same scene with one mesh instanced six times, and with six meshes, each as large as the other's instances.
struct Twins {
  Scene shared = placed_sheets(sheets_in_view(), true).read(), copied = placed_sheets(sheets_in_view(), false).read();
  Twins() {
    for (Scene* scene : {&shared, &copied}) {
      Texture bumps{16, 16};
      for (unsigned i = 0; i < 256; ++i) {
        const auto tilt = static_cast<std::uint8_t>(64 + 7 * (i * i % 19)),
                   sway = static_cast<std::uint8_t>(32 + 9 * (i % 17));
        bumps.rgba.insert(bumps.rgba.end(), {tilt, sway, 230, 255});
      }
      keep_decoded(bumps);
      scene->textures = {bumps};
      scene->environment = {2, 2, {glm::vec3(100), glm::vec3(100), glm::vec3(20), glm::vec3(20)}};
    }
  }
  const Mesh& copy(unsigned placement) const { return copied.meshes[placement]; }
};

CameraView wide_camera() { return phone_camera(4, 96, 72, {}, 5e-5); }

std::array<glm::vec3, 3> corners(const Mesh& mesh, unsigned triangle) {
  const glm::uvec3 t = mesh.triangles[triangle];
  return {mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]};
}

/// The largest difference between the float normals of a triangle in space and of one whose corners lie beside its own
/// by the rounding of a placement (tests/simulator/scene/gltf/instance_test.cpp): twice that over the least height, for
/// either of two edges, and the rounding of the cross product and its length.
float normal_rounding(const std::array<glm::vec3, 3>& p, float magnitude) {
  const float area2 = glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
  const float longest = std::max({glm::distance(p[0], p[1]), glm::distance(p[1], p[2]), glm::distance(p[2], p[0])});
  const float moved = 7 * std::sqrt(3.0f) * kRounding * magnitude;
  return 2 * moved * longest / area2 * 2 + 32 * kRounding;
}

// Rays to the middle of each triangle, from two origins, meet the same object at the same distance in packets of all
// widths and alone. What rays lose on their way is less than by what they leave surfaces, 1e-5 of the largest
// coordinate (pixel.cpp), measured across the surface: else surfaces would shadow themselves.
TEST(Instance, RaysMeetWhatTheyMeetOfCopies) {
  const Twins twins;
  const Intersector shared(twins.shared), copied(twins.copied);
  std::array<int, 6> met_of_object{};
  for (const glm::vec3 origin : {glm::vec3(0), glm::vec3(-7, 5, -2)}) {
    for (const Mesh& target : twins.copied.meshes) {
      for (unsigned triangle = 0; triangle < target.triangles.size(); ++triangle) {
        const auto p = corners(target, triangle);
        const Ray ray{origin, (p[0] + p[1] + p[2]) / 3.0f - origin};
        const std::optional<Hit> hit = shared.intersect(ray), expected = copied.intersect(ray);
        ASSERT_TRUE(hit && expected);
        const Mesh &mesh = twins.shared.meshes[0], &copy = twins.copied.meshes[expected->mesh];
        EXPECT_EQ(hit->mesh, 0u);
        EXPECT_EQ(hit->triangle, expected->triangle);
        const Placement& instance = mesh.placements[hit->placement];
        EXPECT_EQ(instance.object_id, copy.object_id);
        EXPECT_EQ(instance.person, copy.person);
        ++met_of_object[instance.object_id - 1];
        const glm::vec3 normal = geometric_normal(mesh, *hit, ray.direction);
        const glm::vec3 expected_normal = geometric_normal(copy, *expected, ray.direction);
        const glm::vec3 point = origin + expected->t * ray.direction;
        const float magnitude = std::max({largest(point), largest(origin), largest(instance.world_from_mesh[3])});
        const float across = std::abs(glm::dot(ray.direction, expected_normal));
        EXPECT_LE(std::abs(hit->t - expected->t) * across, 1e-5f * magnitude);
        EXPECT_LE(glm::length(normal - expected_normal), normal_rounding(corners(copy, expected->triangle), magnitude));
        for (const int width : {1, 8, 16}) {
          RayPacket rays{};
          alignas(64) int active[kPacket], hidden[kPacket];
          for (int i = 0; i < kPacket; ++i) {
            active[i] = i % 5 ? -1 : 0;
            rays.origin_x[i] = origin.x, rays.origin_y[i] = origin.y, rays.origin_z[i] = origin.z;
            rays.direction_x[i] = ray.direction.x, rays.direction_y[i] = ray.direction.y;
            rays.direction_z[i] = ray.direction.z;
            rays.far[i] = i % 2 ? 1e3f : 0.5f * hit->t;
            rays.mesh[i] = kNoMesh;
          }
          shared.occluded(active, rays, false, hidden, width);
          shared.intersect(active, rays, true, width);
          for (int i = 0; i < kPacket; ++i) {
            const bool meets = active[i] && i % 2;
            ASSERT_EQ(rays.mesh[i], meets ? 0 : kNoMesh) << width;
            ASSERT_EQ(hidden[i], meets ? -1 : 0) << width;
            if (!meets) continue;
            ASSERT_EQ(rays.placement[i], hit->placement) << width;
            ASSERT_EQ(rays.triangle[i], hit->triangle) << width;
            ASSERT_NEAR(rays.far[i], hit->t, 1e-5f * magnitude / across) << width;
          }
        }
      }
    }
  }
  EXPECT_GT(*std::min_element(met_of_object.begin(), met_of_object.end()), 50);
}

// Position, geometric normal, and a normal that is interpolated and bent by a texture, at the same points of both. What
// is interpolated from rounded corners is as far apart as they; lengths and products add a few ulps.
TEST(Instance, SurfacesAreThoseOfCopies) {
  Twins twins;
  for (const bool bumpy : {false, true}) {
    for (Scene* scene : {&twins.shared, &twins.copied}) scene->materials[0].normal_texture.texture = bumpy ? 0 : -1;
    const Mesh& mesh = twins.shared.meshes[0];
    for (unsigned first = 0; first < 288; first += 3) {
      for (unsigned k = 0; k < 6; ++k) {
        RayPacket rays{}, of_copy{};
        alignas(64) int lanes[kPacket] = {};
        for (unsigned i = 1; i < 4; ++i) {
          // three placements at a time, but one in the copies' packet
          rays.placement[i] = of_copy.placement[i] = (k + i) % 6;
          rays.triangle[i] = first + i - 1;
          rays.u[i] = 0.2f, rays.v[i] = 0.5f;
          rays.direction_x[i] = 0.1f, rays.direction_y[i] = -0.2f, rays.direction_z[i] = 1;
          lanes[i] = -1;
        }
        SurfacePacket packet;
        surfaces_at(twins.shared, mesh, lanes, rays, packet);
        for (int i = 1; i < 4; ++i) {
          const unsigned placement = rays.placement[i];
          const glm::mat4x3& matrix = mesh.placements[placement].world_from_mesh;
          const bool mirror = glm::determinant(glm::mat3(matrix)) < 0;
          of_copy = rays;
          if (mirror) of_copy.u[i] = rays.v[i], of_copy.v[i] = rays.u[i];  // the reader has swapped the corners
          alignas(64) int lane[kPacket] = {};
          lane[i] = -1;
          SurfacePacket expected;
          surfaces_at(twins.copied, twins.copy(placement), lane, of_copy, expected);
          const auto p = corners(twins.copy(placement), rays.triangle[i]);
          float magnitude = largest(matrix[3]);
          for (int j = 0; j < 3; ++j) magnitude += largest(matrix[j]);
          EXPECT_LE(largest(packet.position.at(i) - expected.position.at(i)), 14 * kRounding * magnitude);
          EXPECT_GE(packet.magnitude[i], largest(matrix[3]));
          EXPECT_GE(packet.magnitude[i], largest(packet.position.at(i)));
          const float of_face = normal_rounding(p, magnitude);
          EXPECT_LE(glm::length(packet.geometric_normal.at(i) - expected.geometric_normal.at(i)), of_face);
          // the texture adds tangent and bitangent, up to once each, which are as wrong as the face
          EXPECT_LE(glm::length(packet.normal.at(i) - expected.normal.at(i)), bumpy ? 4 * of_face : 64 * kRounding)
              << "triangle " << rays.triangle[i] << " in instance " << placement;
        }
      }
    }
  }
}

// The same picture and truth. Light differs by rounding but where a ray passes an edge within 1e-5 of the largest
// coordinate, 9 m, to either side, and meets something else. Edges in view are 60 m long in 30 m^2, so that 1 ray in
// 2800 does. Of a photosite's 64 paths each has up to six rays: 1 photosite in 7 may differ by one path or so, either
// way.
TEST(SlowInstance, PictureAndTruthAreThoseOfCopies) {
  Twins twins;
  for (Scene* scene : {&twins.shared, &twins.copied}) scene->materials[0].normal_texture.texture = 0;
  const RenderScene shared(twins.shared), copied(twins.copied);
  const CameraView camera = wide_camera();
  const Truth truth = trace_truth(shared, camera), expected = trace_truth(copied, camera);
  EXPECT_EQ(truth.object_id.data, expected.object_id.data);
  EXPECT_EQ(truth.person_mask.data, expected.person_mask.data);
  EXPECT_EQ(truth.valid.data, expected.valid.data);
  EXPECT_GT(std::count(truth.person_mask.data.begin(), truth.person_mask.data.end(), 1.0f), 100);
  for (int y = 0; y < 72; ++y) {
    for (int x = 0; x < 96; ++x) {
      if (expected.valid.at(x, y) == 0) continue;
      glm::vec3 normal, expected_normal;
      for (int c = 0; c < 3; ++c)
        normal[c] = truth.normal.at(x, y, c), expected_normal[c] = expected.normal.at(x, y, c);
      const glm::dvec2 at_m = camera.lens.sensor().middle_m(x, y);
      const glm::vec3 ray(camera.lens.chief_slope(at_m.x, at_m.y), 1);
      const float depth_m = expected.depth_m.at(x, y), magnitude = std::max(9.0f, largest(depth_m * ray));
      EXPECT_LE(std::abs((truth.depth_m.at(x, y) - depth_m) * glm::dot(ray, expected_normal)), 1e-5f * magnitude);
      // the thinnest triangles are 0.045 m high
      EXPECT_LE(glm::length(normal - expected_normal), 7 * std::sqrt(3.0f) * kRounding * magnitude * 4 / 0.045f);
    }
  }
  const Image picture = undivided(render_views(shared, camera, {64, 2, 5}));
  const Image wanted = undivided(render_views(copied, camera, {64, 2, 5}));
  int different = 0, lit = 0;
  double sum = 0, wanted_sum = 0;
  for (std::size_t i = 0; i < picture.data.size(); i += 3) {
    different += !(std::abs(picture.data[i] - wanted.data[i]) <= 1e-4f * wanted.data[i]);
    lit += wanted.data[i] > 0 && wanted.data[i] < 100;
    sum += picture.data[i];
    wanted_sum += wanted.data[i];
  }
  EXPECT_GT(lit, 4000);
  constexpr double kPhotosites = 96 * 72;
  EXPECT_LE(different, kPhotosites / 7);
  EXPECT_NEAR(sum / wanted_sum, 1, std::sqrt(kPhotosites / 7) / (64 * kPhotosites) * 2);
}

// A placed mesh that moves takes the points on it along.
TEST(Instance, MotionFollowsPlacements) {
  const Twins first;
  Twins later;
  const glm::vec3 shift(0.03f, -0.02f, 0.1f);
  later.shared.meshes[0].placements[1].world_from_mesh[3] += shift;
  for (glm::vec3& p : later.copied.meshes[1].positions) p += shift;
  const CameraView camera = wide_camera();
  const Image motion = trace_motion(RenderScene(first.shared), camera, later.shared, camera);
  const Image expected = trace_motion(RenderScene(first.copied), camera, later.copied, camera);
  const Truth truth = trace_truth(RenderScene(first.copied), camera);
  const double focal_px = thin(camera).image_distance_m() / 5e-5;
  int moved = 0;
  for (int y = 0; y < motion.height; ++y) {
    for (int x = 0; x < motion.width; ++x) {
      for (int c = 0; c < 2; ++c) {
        if (std::isinf(expected.at(x, y, c))) {
          EXPECT_EQ(motion.at(x, y, c), expected.at(x, y, c));
          continue;
        }
        // points lie within 1e-5 of the largest coordinate, 9 m, seen from a distance of 2 m and more
        EXPECT_NEAR(motion.at(x, y, c), expected.at(x, y, c), 1e-5 * 9 / 2 * focal_px);
      }
      moved += truth.object_id.at(x, y) == 2 && std::abs(motion.at(x, y, 0)) > 0.3f;
    }
  }
  EXPECT_GT(moved, 100);
  EXPECT_FALSE(mesh_that_differs(first.shared, later.shared));
  later.shared.meshes[0].placements.pop_back();
  EXPECT_EQ(mesh_that_differs(first.shared, later.shared), 0u);
}

/// Of this process, now, what was freed handed back.
double resident_bytes() {
  malloc_trim(0);
  std::ifstream statm("/proc/self/statm");
  double all = 0, resident = 0;
  statm >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

// Ten million triangles: a thousand instances of ten thousand. The scene and Embree's structures take what those of one
// copy take, 1.1 MB, and less than a kilobyte for each instance, not a gigabyte; 4 MB are for the pools of
// threads.
TEST(Instance, TenMillionTrianglesTakeTheMemoryOfTenThousand) {
  constexpr int kPlaces = 1000, kSide = 71;  // 10082 triangles
  const auto bytes_of = [](int instances) {
    nlohmann::json nodes = nlohmann::json::array();
    for (int i = 0; i < instances; ++i) nodes.push_back({{"translation", {3 * i, 0, 0}}});
    const GltfBuilder gltf = placed_sheets(nodes, true, kSide);
    const double before = resident_bytes();
    const Scene scene = gltf.read();
    const Intersector intersector(scene);
    EXPECT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(scene.meshes[0].triangles.size(), 2u * kSide * kSide);
    return resident_bytes() - before;
  };
  bytes_of(2);  // whatever is allocated once, threads' pools among it
  const double one = bytes_of(2), all = bytes_of(kPlaces);
  EXPECT_LT(all, one + kPlaces * 1024 + 4e6);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
