#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "evaluation/benchmarks/smoothing_benchmark.h"
#include "evaluation/report/page.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct BenchEdgesOptions {
  std::string capture;
  std::string page;
  bool json = false;
};

void print(const evaluation::SmoothingBenchmark& benchmark) {
  const evaluation::SmoothingStages& stages = benchmark.stages;
  fmt::print(
      "disparity {:6.1f} ms ({:.1f} ms of CPU): solve {:.1f}, median {:.1f}, upsample {:.1f}\n"
      "mask      {:6.1f} ms ({:.1f} ms of CPU)\n",
      stages.solve_ms + stages.median_ms + stages.upsample_ms, stages.disparity_cpu_ms, stages.solve_ms,
      stages.median_ms, stages.upsample_ms, stages.mask_ms, stages.mask_cpu_ms);
  for (const evaluation::SmoothingStages::MaskScore& mask : stages.masks) {
    fmt::print("  boundary F at 2 px, {:<20}{:.3f}\n", mask.name, mask.boundary_f);
  }
  for (const evaluation::SolverComparison& c : benchmark.opencv) {
    fmt::print(
        "cells [{:.1f},{:.1f},{:.1f}]: {:.1f} ms (grid {:.1f}), OpenCV {:.1f}: {:.2f} times; {:.1f} MB, OpenCV {:.1f} "
        "MB; RMSE {:.4f} / {:.4f}, at edges {:.4f} / {:.4f}, width {:.1f} / {:.1f} px\n",
        c.cells.cell_px, c.cells.cell_luma, c.cells.cell_chroma, c.ms, c.grid_ms, c.opencv_ms, c.opencv_ms / c.ms,
        c.peak_mb, c.opencv_peak_mb, c.ours.rmse_dp_px, c.opencv.rmse_dp_px, c.ours.edge_rmse_dp_px,
        c.opencv.edge_rmse_dp_px, c.ours.edge_width_px, c.opencv.edge_width_px);
  }
  for (const evaluation::SolverFailure& f : benchmark.failures) {
    fmt::print("{:<36}{:<56}{:>10.4g}{:>10}\n", f.failure, f.figure, f.ours,
               f.opencv ? fmt::format("{:.4g}", *f.opencv) : "");
  }
  const auto table = [&](const char* target, evaluation::SmoothingRun evaluation::SmoothingComparison::*of) {
    fmt::print("{:<28}{:<18}{:>8}{:>8}{:>9}{:>9}{:>11}{:>10}{:>9}{:>10}\n", target, "", "ms", "CPU ms", "RMSE", "MAE",
               "edge RMSE", "edge MAE", "width", "thin MAE");
    for (const evaluation::SmoothingComparison& method : benchmark.methods) {
      const evaluation::SmoothingRun& run = method.*of;
      const evaluation::SmoothingErrors& e = run.errors;
      fmt::print("{:<28}{:<18}{:>8.1f}{:>8.1f}{:>9.4f}{:>9.4f}{:>11.4f}{:>10.4f}{:>9.1f}{:>10.4f}\n", method.family,
                 method.name, run.ms, run.cpu_ms, e.rmse_dp_px, e.mae_dp_px, e.edge_rmse_dp_px, e.edge_mae_dp_px,
                 e.edge_width_px, e.thin_mae_dp_px);
    }
  };
  fmt::print("times below: solver, median and upsampling, encoding the full-size guide included\n");
  table("matched", &evaluation::SmoothingComparison::matched);
  table("known", &evaluation::SmoothingComparison::known);
}

void run(const BenchEdgesOptions& options) {
  Progress progress("smoothing");
  const evaluation::SmoothingBenchmark benchmark =
      evaluation::measure_smoothing(options.capture, [&](double fraction) { progress(fraction); });
  if (!options.page.empty()) evaluation::write_page(options.page, evaluation::to_page(benchmark));
  if (options.json) {
    std::cout << evaluation::to_json(benchmark).dump(2) << '\n';
  } else {
    print(benchmark);
  }
}

}  // namespace

void add_bench_edges(CLI::App& bench) {
  auto options = std::make_shared<BenchEdgesOptions>();
  CLI::App* command = bench.add_subcommand(
      "edges", "Time and error of edge-aware smoothing, and of OpenCV's where built in, on a rendered capture");
  command->add_option("capture", options->capture, "Capture folder that holds truth")->type_name("CAPTURE")->required();
  command->add_option("-o,--output", options->page, "Write a page with the charts")->type_name("PAGE.html");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(
      "Example:\n  dualpixel simulate build/release/scenes/portrait.json -o out/portrait\n  dualpixel bench edges "
      "out/portrait -o "
      "bench-edges.html");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
