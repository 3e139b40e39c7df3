#include <CLI/CLI.hpp>
#include <string>

#include "capture/files.h"
#include "tools/cli/small_program.h"
#include "tools/export_onnx/onnx_model.h"

int main(int argc, char** argv) {
  CLI::App program("Writes the person segmentation network as an ONNX model.", "dualpixel_export_onnx");
  std::string weights, output;
  program.add_option("--weights", weights, "Other weights than the built-in ones: person.safetensors of a run")
      ->type_name("FILE");
  program.add_option("-o,--output", output, "The model")->required()->type_name("FILE");
  program.footer("Example:\n  dualpixel_export_onnx -o out/person.onnx");
  return dualpixel::tools::run_small_program(program, argc, argv, [&] {
    dualpixel::replace_file(output,
                            dualpixel::tools::onnx_model(weights.empty() ? dualpixel::pipeline::built_in_weights()
                                                                         : dualpixel::pipeline::read_weights(weights)));
    return 0;
  });
}
