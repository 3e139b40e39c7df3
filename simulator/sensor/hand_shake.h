#pragma once
#include <cstdint>
#include <glm/glm.hpp>

/// How a phone moves in the hands that hold it while a burst is taken.
///
/// Angular speed about each axis is a Gaussian process of even power from 0.5 to 12 Hz, made of sinusoids of random
/// phase (Rice 1944, "Mathematical Analysis of Random Noise"), one in each of 24 equal bands. So the angle's power
/// falls as 1/f^2 and the path is smooth. The band reaches from the sway that a person corrects to the upper end of
/// physiological tremor, 8-12 Hz (as in Wronski et al. 2019, "Handheld Multi-Frame Super-Resolution", section 4); the
/// vibration measured on hand-held cameras, at 2 and 4 Hz (Japanese Journal of Ergonomics 31(6), p. 399, 1995), lies
/// inside it. Position is a path of the same spectrum.
///
/// Amplitudes at scale 1:
/// - Angular speed 0.015 rad/s RMS about each axis. The photographers' rule that a picture may be held by hand for
///   1 / (focal length in mm) s asks for a blur of at most 0.03 mm on 35 mm film, which is 0.03 rad/s: here two
///   standard deviations.
/// - Position 0.2 mm RMS along each axis: measured tremor of a hand-held instrument is 0.25, 0.17 (across) and 0.02 mm
///   (along it) RMS (PMC3032442, Fig. 4). That it is alike along all axes is ours; rotation prevails beyond 0.2 m.
namespace dualpixel::simulator {

/// The pose at `time_s` in the camera's axes at time 0, where it is the identity; rigid. A function of its arguments
/// alone; any time, finite. `scale` multiplies both amplitudes.
glm::dmat4 hand_shake(std::uint64_t seed, double time_s, double scale);

}  // namespace dualpixel::simulator
