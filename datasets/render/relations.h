#pragma once
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "datasets/plan/sample_line.h"
#include "scenes/drawn/meter.h"
#include "simulator/ready_scene.h"
#include "simulator/render/camera_view.h"

/// What depends on the scene as the camera sees it: a line holds the numbers that were drawn, rays say what they mean.
namespace dualpixel::datasets {

/// Where in the picture the camera focuses, in shares of its sides: the line's focus_at, or the middle where the scene
/// file's distance is "auto"; empty: at a distance.
std::optional<std::array<double, 2>> focus_place(const SampleLine& line, const nlohmann::json& scene_file);

/// For checking a line before its scene is loaded: puts some camera, and some distance of focus, where the line's is
/// not known yet.
void stand_in_for_relations(const SampleLine& line, nlohmann::json& scene_file);

/// Places the camera as the line's camera_shell says, and focuses it on what it sees at `focus`. Throws InputError
/// where there is no free place, or nothing to focus on.
void resolve_geometry(const SampleLine& line, const std::optional<std::array<double, 2>>& focus,
                      const simulator::ReadyScene& ready, const std::string& path, nlohmann::json& scene_file);

/// Sets time and gain so that the mean of the picture's signal, clipped at white, is `mean`: of the green photosites,
/// in each of a grid of them, through the lens with its shading. The field that `set` has stays (exposure.time_s or
/// exposure.iso); where it has neither, both follow as a phone shares light between them (scenes/drawn/meter.h).
/// Returns how far it is from that, where no exposure is or the camera allows none. Throws InputError where the scene
/// is black.
std::optional<scenes::MissedExposure> resolve_exposure(double mean, const nlohmann::json& set,
                                                       const simulator::Simulation& simulation,
                                                       simulator::ReadyScene& ready,
                                                       const simulator::CameraView& camera, nlohmann::json& scene_file);

}  // namespace dualpixel::datasets
