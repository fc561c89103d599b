// What the three scan readers share; read_scan() is the only user. Not part of the data model's interface.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "dataset/model/scan.h"
#include "dataset/model/scan_files.h"

namespace ohb {

/// Most corners, positions or UVs of a scan: memory stays below about 4 GiB whatever a file says.
constexpr size_t kMaxScanElements = 64u << 20;
/// Most corners of one face: ear clipping takes quadratic time in them.
constexpr size_t kMaxFaceCorners = 2048;
/// Most materials and groups (16-bit indices).
constexpr size_t kMaxScanNames = 65535;

/// Each fills positions, UVs, faces, materials and groups as the file orders them. Throws InputError.
Scan read_obj(const std::filesystem::path& file);
Scan read_gltf(const std::filesystem::path& file);
Scan read_fbx(const std::filesystem::path& file);

/// Materials of an .mtl file by name. `notes` gets what was seen and not used. Throws InputError with the
/// line.
std::map<std::string, ScanMaterial> read_mtl(const std::filesystem::path& file, ScanFiles& files,
                                             std::vector<std::string>& notes);

/// `name` with "<UDIM>" replaced by the number of the first tile that is in the folder (1001 if none is).
std::string first_udim_tile(const std::filesystem::path& folder, const std::string& name);
/// `name` with "<UDIM>" replaced by the number of the tile that `of` holds; `name` itself if either has none.
std::string with_udim_tile_of(const std::string& name, const std::string& of);

/// Makes each tile a material of its own, "<material>.<tile>", with its UVs in [0,1]: for materials with a
/// picture whose name holds a tile's number (1001 to 1999) and beside which there is one of another tile.
/// Faces belong to the tile of their middle. Pictures without a number repeat on every tile. A tile whose
/// picture is not there goes into Scan::missing. Throws InputError for faces outside the tiles.
void split_udim_tiles(Scan& scan);

/// Makes the views of pictures plain where UVs can be moved for it: UVs of a material are moved as its first
/// picture's view says, and brought from all tiles that they use into [0,1] where a picture does not repeat
/// (so that one map shows it all). Views that are left are read_image()'s matter. Throws InputError for a
/// view that is not finite or too large.
void settle_pictures(Scan& scan);

/// Sets has_vertex_colours, has_vertex_alpha and, without an alpha picture, the opacity that a cutoff leaves.
void settle_opacity(Scan& scan);

/// OBJ and FBX: colours at the vertices (`corner_colours`) stand for the colour of materials without a
/// picture, and are not used where there is one. `is_coloured`: by face; may be shorter, the rest is not.
void settle_vertex_colours(Scan& scan, std::vector<bool> is_coloured);

/// Stores positions in single precision. Where that would lose detail (they lie 100 times as far from the
/// origin as they are apart) a round offset is taken off first, stated in removed_offset and the notes.
void store_positions(Scan& scan, const std::vector<Vec3d>& positions);

/// An embedded picture, checked to be an image. `name` makes the key unique within `scan_file`.
ScanPicture embed_picture(const std::filesystem::path& scan_file, const std::string& name, std::string bytes);

/// True if the picture's colours are those of directions, false for a grey height map (exporters write both
/// as "bump"). Decodes the picture. Throws InputError.
bool is_normal_map(const ScanPicture& picture);

/// Starts a face of that material and group; append its corners, then start the next or close_faces().
void begin_face(Scan& scan, size_t material, size_t group);
/// Ends the last face.
void close_faces(Scan& scan);

/// Merges positions [first, end) that are bitwise equal (-0 counts as 0), and lets the corners from
/// `first_corner` on use the first of each. Corner order does not change.
void weld_positions(Scan& scan, size_t first, size_t first_corner);

/// "vertex 17 of group 'body'": numbers from 1, as editors count.
std::string numbered(const char* what, size_t index);

}  // namespace ohb
