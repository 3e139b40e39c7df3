#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

/// What can be chosen of a drawn scene: one table for each kind of scene, from which --set, help, lists and refusals
/// follow.
namespace dualpixel::scenes {

struct Parameter {
  enum class Type : std::uint8_t {
    number,
    logarithmic,  ///< a number that is drawn with equal chances per octave
    integer,
    multiple_of_16,
    folder  ///< a path; low and high are not used; where it is not set: none
  };
  const char* name;
  const char* unit;  ///< "" where it has none
  Type type;
  double low, high;              ///< what is allowed
  double drawn_low, drawn_high;  ///< where it is not set: the range that the seed draws from; equal: the default
  const char* description;
  std::vector<const char*> choices = {};  ///< not empty: the value is one of these names; low and high are not used
  const char* usual = nullptr;            ///< the default choice; null: drawn
};

/// The values of one scene.
class Parameters {
 public:
  double number(const std::string& name) const { return numbers_.at(name); }
  float real(const std::string& name) const { return static_cast<float>(number(name)); }
  int integer(const std::string& name) const { return static_cast<int>(number(name)); }
  const std::string& choice(const std::string& name) const { return choices_.at(name); }
  /// "": none.
  const std::string& folder(const std::string& name) const { return choices_.at(name); }
  const std::map<std::string, double>& numbers() const { return numbers_; }
  const std::map<std::string, std::string>& choices() const { return choices_; }

 private:
  friend Parameters draw_parameters(const std::string&, std::span<const Parameter>, const std::vector<std::string>&,
                                    std::uint64_t);
  std::map<std::string, double> numbers_;
  std::map<std::string, std::string> choices_;
};

/// Values of all rows: of `assignments` ("objects=12") where they name them, else drawn from the seed; a row's draw
/// depends on its name and the seed alone. Throws InputError that names the scene's kind, the parameter, the value and
/// what is allowed.
Parameters draw_parameters(const std::string& kind, std::span<const Parameter> table,
                           const std::vector<std::string>& assignments, std::uint64_t seed);

/// Of numbers that must be whole 1, or 16 for multiples of that; 0: all between the limits are allowed.
int step_of(const Parameter& parameter);
/// "0.1 .. 4", "3 .. 40, whole", "128 .. 8192, by 16", "window, lamp, sun"
std::string allowed_text(const Parameter& parameter);
/// "8 .. 20", "drawn", "1"
std::string drawn_text(const Parameter& parameter);

}  // namespace dualpixel::scenes
