#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>
#include <string>

#include "capture/error.h"
#include "capture/files.h"
#include "tools/export_onnx/onnx_model.h"

int main(int argc, char** argv) {
  CLI::App program("Writes the person segmentation network as an ONNX model.", "dualpixel_export_onnx");
  std::string weights, output;
  program.add_option("--weights", weights, "Other weights than the built-in ones: person.safetensors of a run")
      ->type_name("FILE");
  program.add_option("-o,--output", output, "The model")->required()->type_name("FILE");
  program.footer("Example:\n  dualpixel_export_onnx -o out/person.onnx");
  try {
    program.parse(argc, argv);
    dualpixel::replace_file(output,
                            dualpixel::tools::onnx_model(weights.empty() ? dualpixel::pipeline::built_in_weights()
                                                                         : dualpixel::pipeline::read_weights(weights)));
    return 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);
    std::cerr << "dualpixel_export_onnx: " << dualpixel::printable(error.what()) << '\n';
    return 2;
  } catch (const dualpixel::InputError& error) {
    std::cerr << "dualpixel_export_onnx: " << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "dualpixel_export_onnx: " << dualpixel::printable(error.what()) << '\n';
    return 1;
  }
}
