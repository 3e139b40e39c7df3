#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/json_fields.h"
#include "datasets/recipe/draws.h"

namespace dualpixel::datasets {

/// What a field of a recipe may be: a value, or how to draw one.
struct Distribution {
  enum class Kind {
    constant,     ///< {"constant": value}, or the value itself where it is no object
    choice,       ///< {"choice": [values], "weights": [numbers]}; without weights all are equally likely
    uniform,      ///< {"uniform": [low, high]}
    log_uniform,  ///< {"log_uniform": [low, high]}: equal chances per octave
    integer,      ///< {"integer": [low, high]}: whole numbers, both ends included
    normal,       ///< {"normal": [mean, deviation], "bounds": [low, high]}: its part between the bounds
    grid          ///< {"grid": [values]}: all combinations of all grids in turn, from sample to sample
  };
  Kind kind = Kind::constant;
  std::vector<nlohmann::json> values;  ///< of constant (one), choice and grid
  std::vector<double> weights;         ///< of choice, one for each value
  double low = 0, high = 0;            ///< of the kinds with a range
  double mean = 0, deviation = 0;      ///< of normal
};

/// Reads the field `key`, which must be there. Throws InputError that names file, field, value and what is allowed.
Distribution read_distribution(Fields& fields, const std::string& key);

/// The same where every value must be a number in a closed range.
Distribution read_numbers(Fields& fields, const std::string& key, double low, double high);

/// One value; numbers of continuous kinds have six digits. `grid_position` is that in the list of a grid.
nlohmann::json draw(const Distribution& distribution, Draws draws, std::size_t grid_position);

}  // namespace dualpixel::datasets
