// One function per kind; generate() chooses.
#pragma once

#include <antumbra/generate.hpp>

namespace antumbra::generation {

/// Two furnished rooms: 159 objects (Gotsman, Sudarsky, Fayman 1999, section 8). No size but this one;
/// `copies` makes the paper's apartment block.
Result<RawScene> apartment(const GenerateOptions& options);
/// Closed blocks of buildings along straight streets, with windows, roofs and street furniture as objects.
Result<RawScene> city(const GenerateOptions& options);
/// Copies of a district of towers on straight streets (Poon, Wang 1999, section 6).
Result<RawScene> downtown(const GenerateOptions& options);
/// Trees of 1,000 triangles each on uneven ground (Nirenstein, Blake, Gain 2002, section 6).
Result<RawScene> forest(const GenerateOptions& options);
/// The same ground and places, trees closed down to the ground: a cell of 20 x 20 sees about as large a share as the paper's.
Result<RawScene> forest_dense(const GenerateOptions& options);
/// A copier-like housing: 1,726 parts, 455,806 triangles (Gotsman, Sudarsky, Fayman 1999, section 8). One
/// size.
Result<RawScene> machine(const GenerateOptions& options);
/// Storeys of rooms along a corridor, with stairs and plants (Bittner, Havran, Slavik 1998, section 7).
Result<RawScene> office(const GenerateOptions& options);
/// A walled town of furnished timber houses on narrow rings of streets (Nirenstein, Blake, Gain 2002, section
/// 6).
Result<RawScene> town(const GenerateOptions& options);

} // namespace antumbra::generation
