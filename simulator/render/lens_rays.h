#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "simulator/render/camera_view.h"
#include "simulator/render/intersector.h"
#include "simulator/render/sobol.h"

/// From joint samples to camera rays, sixteen of one pixel at a time: the thin lens in single precision.
namespace dualpixel::simulator {

/// Concentric map of the unit square onto the unit disc (Shirley & Chiu 1997): keeps the sign of x - 1/2, so the two
/// halves of the pupil are stratified each. Branch-free, polynomials for sine and cosine on [-pi/4, pi/4].
inline void concentric_disc(const float u[kPacket], const float v[kPacket], float x[kPacket], float y[kPacket]) {
  for (int i = 0; i < kPacket; ++i) {
    const float a = 2 * u[i] - 1;
    const float b = 2 * v[i] - 1;
    const bool wide = std::abs(a) > std::abs(b);
    const float r = wide ? a : b;
    const float ratio = (wide ? b : a) / std::copysign(std::max(std::abs(r), 1e-20f), r);
    const float t = 0.785398163f * ratio;
    const float t2 = t * t;
    const float sine =
        t * (1 + t2 * (-1.66666667e-1f + t2 * (8.33333333e-3f + t2 * (-1.98412698e-4f + t2 * 2.7557e-6f))));
    const float cosine = 1 + t2 * (-0.5f + t2 * (4.16666667e-2f + t2 * (-1.38888889e-3f + t2 * 2.48016e-5f)));
    x[i] = r * (wide ? cosine : sine);
    y[i] = r * (wide ? sine : cosine);
  }
}

/// The camera's constants in single precision, as the ray loop wants them.
struct LensRays {
  LensRays(const CameraView& camera, double aperture_scale) {
    const double x_per_px = camera.pixel_pitch_m / camera.lens.image_distance_m();
    scale = static_cast<float>(x_per_px);
    centre_x = static_cast<float>(camera.principal_point_px.x);
    centre_y = static_cast<float>(camera.principal_point_px.y);
    radius = static_cast<float>(0.5 * camera.lens.pupil_diameter_m() * aperture_scale);
    inverse_focus = static_cast<float>(1 / camera.lens.focus_distance_m);
    rotation = glm::mat3(camera.world_from_camera);
    origin = glm::vec3(camera.world_from_camera[3]);
  }

  /// Rays of one pixel from joint samples; p: pupil positions in units of its radius. The direction's camera-space z
  /// is 1, so a hit's t is its planar depth.
  void make(int pixel_x, int pixel_y, const float s[4][kPacket], float p[2][kPacket], RTCRayHit16& rays) const {
    concentric_disc(s[2], s[3], p[0], p[1]);
    for (int i = 0; i < kPacket; ++i) {
      const float lens_x = p[0][i] * radius;
      const float lens_y = p[1][i] * radius;
      const float dx = (pixel_x - centre_x + s[0][i]) * scale - lens_x * inverse_focus;
      const float dy = (pixel_y - centre_y + s[1][i]) * scale - lens_y * inverse_focus;
      rays.ray.org_x[i] = origin.x + rotation[0].x * lens_x + rotation[1].x * lens_y;
      rays.ray.org_y[i] = origin.y + rotation[0].y * lens_x + rotation[1].y * lens_y;
      rays.ray.org_z[i] = origin.z + rotation[0].z * lens_x + rotation[1].z * lens_y;
      rays.ray.dir_x[i] = rotation[0].x * dx + rotation[1].x * dy + rotation[2].x;
      rays.ray.dir_y[i] = rotation[0].y * dx + rotation[1].y * dy + rotation[2].y;
      rays.ray.dir_z[i] = rotation[0].z * dx + rotation[1].z * dy + rotation[2].z;
    }
    reset(rays);
  }

  static void reset(RTCRayHit16& rays) {
    for (int i = 0; i < kPacket; ++i) {
      rays.ray.tnear[i] = 0;
      rays.ray.tfar[i] = std::numeric_limits<float>::infinity();
      rays.ray.time[i] = 0;
      rays.ray.mask[i] = ~0u;
      rays.ray.flags[i] = 0;
      rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
  }

  float scale, centre_x, centre_y, radius, inverse_focus;
  glm::mat3 rotation;
  glm::vec3 origin;
};

}  // namespace dualpixel::simulator
