#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

/// The networks' trained weights, and the safetensors files that hold them: eight bytes of header length
/// (little-endian), a JSON header that gives each tensor's type, shape and offsets, then the numbers.
namespace dualpixel::pipeline {

/// A convolution y = weight * x + bias, batch normalization folded into it.
struct ConvWeights {
  int out = 0, in = 0, kernel = 0;
  std::vector<float> weight;  ///< out x in x kernel x kernel
  std::vector<float> bias;    ///< out
};

enum class NetworkKind {
  person,  ///< network.h: a picture and a seed, to a mask
  faces    ///< face_network.h: a picture, to a map of faces
};

/// The network's layers, by name; network.h defines how they connect.
///   stem_half, stem_fine, stem_quarter
///   stageS.across0..3, stageS.down1..3, stageS.lateral0..2, stageS.up0..2, for each stage S
///   betweenS, for each stage but the last; and of the last alone maskS.coarse, maskS.mix, maskS.sub_pixels, or for
///   faces face_map
struct NetworkWeights {
  int stages = 0;                  ///< 1 to 3; of faces 1
  int fine_channels = 0;           ///< at 128 x 128
  std::vector<int> unet_channels;  ///< at 64, 32, 16 and 8 px
  std::map<std::string, ConvWeights> layers;
  std::string file;       ///< that they were read from, for messages
  std::string file_hash;  ///< of the file that they were read from (capture/files.h): which network it was
};

/// Reads a safetensors file of 16- or 32-bit floats. `file` names it in messages. Throws InputError, with one line that
/// names file and tensor, where the file is cut off or damaged, offsets overlap or leave gaps, a number is not finite,
/// or the layers are not those of such a network.
NetworkWeights parse_weights(std::string_view bytes, const std::string& file, NetworkKind kind = NetworkKind::person);

NetworkWeights read_weights(const std::string& path, NetworkKind kind = NetworkKind::person);

/// Those trained for this release (docs/segmentation.md). Throws InputError in a build without them.
const NetworkWeights& built_in_weights(NetworkKind kind = NetworkKind::person);

}  // namespace dualpixel::pipeline
