// Whether what claims to be right to p is right to p, by area: a reliability diagram. Faces of one garment
// are right or wrong together, so that a bin says no more than it holds garments: strictly, in ten bins of
// equal width whatever they hold; and in bins of equal area that hold kLeastPieces garments or more. Each
// with the 90 % interval that so many garments leave: of n that are all right no more than n / (n + 2.7) is
// shown.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace ohb {

/// Faces of one person's piece that claim the same.
struct Claim {
  float claimed = 0;
  double area = 0, right = 0;  // share of the person's area; of it what is right
  uint32_t piece = 0;          // a garment, or a part of the body
};

/// All forms of one person are of one name, each person in as many.
struct PersonClaims {
  std::string person;
  std::vector<Claim> claims;
};

struct ReliabilityBin {
  double area = 0, claimed = 0, right = 0;  // share of the area, and of it what is claimed, and right
  size_t pieces = 0;                        // with kLeastOfPiece of their person's area and more in it
  double garments = 0;       // as many of equal area as tell as much, all forms of one garment being one
  double low = 0, high = 0;  // of right / area: Wilson's score interval at 90 % for so many garments

  double error() const { return (claimed - right) / area; }
};
constexpr size_t kLeastPieces = 20;
constexpr double kLeastOfPiece = 0.01;

/// Each person counts the same.
std::vector<ReliabilityBin> bins_of_equal_width(const std::vector<PersonClaims>& people);
std::vector<ReliabilityBin> bins_of_equal_area(const std::vector<PersonClaims>& people);

/// The largest |error| of bins of 1 % of the area and more.
double largest_error(const std::vector<ReliabilityBin>& bins);
/// Mean |error| by area (expected calibration error).
double expected_error(const std::vector<ReliabilityBin>& bins);

/// Both kinds of bins, a line each.
std::string reliability_text(const std::vector<PersonClaims>& people);

}  // namespace ohb
