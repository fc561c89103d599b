// A square of one quad as FBX 7.4, binary and ASCII: metres, one material, UVs, a node that scales by 2.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace ohb {

/// Builds the binary encoding node by node.
class FbxWriter {
 public:
  template <typename T>
  static std::string raw(T value) {
    std::string bytes(sizeof(T), '\0');
    std::memcpy(bytes.data(), &value, sizeof(T));
    return bytes;
  }
  static std::string text(const std::string& value) {
    return "S" + raw(static_cast<uint32_t>(value.size())) + value;
  }
  static std::string integer(int64_t value) { return "L" + raw(value); }
  static std::string number(double value) { return "D" + raw(value); }
  template <typename T>
  static std::string array(char type, const std::vector<T>& values, bool packed) {
    std::string bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    if (packed) {
      uLongf size = compressBound(bytes.size());
      std::string small(size, '\0');
      compress(reinterpret_cast<Bytef*>(small.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
               bytes.size());
      bytes = small.substr(0, size);
    }
    return std::string(1, type) + raw(static_cast<uint32_t>(values.size())) +
           raw(static_cast<uint32_t>(packed)) + raw(static_cast<uint32_t>(bytes.size())) + bytes;
  }

  void begin(const std::string& name, const std::vector<std::string>& values = {}) {
    open_.push_back(bytes_.size());
    std::string joined;
    for (const std::string& value : values) joined += value;
    bytes_ += raw(uint32_t{0}) + raw(static_cast<uint32_t>(values.size())) +
              raw(static_cast<uint32_t>(joined.size()));
    bytes_ += static_cast<char>(name.size());
    bytes_ += name + joined;
    has_children_.push_back(false);
  }
  void end() {
    if (has_children_.back()) bytes_ += std::string(13, '\0');
    const std::string end = raw(static_cast<uint32_t>(bytes_.size()));
    bytes_.replace(open_.back(), 4, end);
    open_.pop_back();
    has_children_.pop_back();
    if (!has_children_.empty()) has_children_.back() = true;
  }
  void leaf(const std::string& name, const std::vector<std::string>& values) {
    begin(name, values);
    end();
  }
  std::string finish() { return bytes_ + std::string(13, '\0') + std::string(176, '\x11'); }

 private:
  static std::string header() {
    return std::string("Kaydara FBX Binary  \0\x1a\0", 23) + raw(uint32_t{7400});
  }
  std::string bytes_ = header();
  std::vector<size_t> open_;
  std::vector<bool> has_children_;
};

inline std::string quad_fbx() {
  using W = FbxWriter;
  W w;
  w.begin("GlobalSettings");
  w.begin("Properties70");
  w.leaf("P",
         {W::text("UnitScaleFactor"), W::text("double"), W::text("Number"), W::text(""), W::number(100)});
  w.end();
  w.end();
  w.begin("Objects");
  w.begin("Geometry", {W::integer(10), W::text(std::string("q\0\1Geometry", 11)), W::text("Mesh")});
  w.leaf("Vertices", {W::array<double>('d', {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, true)});
  w.leaf("PolygonVertexIndex", {W::array<int32_t>('i', {0, 1, 2, -4}, false)});
  w.begin("LayerElementUV", {"I" + W::raw(int32_t{0})});
  w.leaf("MappingInformationType", {W::text("ByPolygonVertex")});
  w.leaf("UV", {W::array<double>('d', {0, 0, 1, 0, 1, 1, 0, 1}, false)});
  w.leaf("UVIndex", {W::array<int32_t>('i', {0, 1, 2, 3}, true)});
  w.end();
  w.begin("LayerElementMaterial", {"I" + W::raw(int32_t{0})});
  w.leaf("MappingInformationType", {W::text("AllSame")});
  w.leaf("Materials", {W::array<int32_t>('i', {0}, false)});
  w.end();
  w.end();
  w.begin("Model", {W::integer(20), W::text(std::string("body\0\1Model", 11)), W::text("Mesh")});
  w.begin("Properties70");
  w.leaf("P", {W::text("Lcl Scaling"), W::text("Lcl Scaling"), W::text(""), W::text("A"), W::number(2),
               W::number(2), W::number(2)});
  w.end();
  w.end();
  w.leaf("Material", {W::integer(30), W::text(std::string("cloth\0\1Material", 15)), W::text("")});
  w.end();
  w.begin("Connections");
  w.leaf("C", {W::text("OO"), W::integer(10), W::integer(20)});
  w.leaf("C", {W::text("OO"), W::integer(20), W::integer(0)});
  w.leaf("C", {W::text("OO"), W::integer(30), W::integer(20)});
  w.end();
  return w.finish();
}

inline std::string ascii_quad_fbx() {
  return R"(; FBX 7.4.0 project file
FBXHeaderExtension:  {
	FBXVersion: 7400
}
GlobalSettings:  {
	Properties70:  {
		P: "UnitScaleFactor", "double", "Number", "",100
	}
}
Objects:  {
	Geometry: 10, "Geometry::q", "Mesh" {
		Vertices: *12 {
			a: 0,0,0,1,0,0,
1,1,0,0,1,0
		}
		PolygonVertexIndex: *4 {
			a: 0,1,2,-4
		}
		LayerElementUV: 0 {
			MappingInformationType: "ByPolygonVertex"
			UV: *8 {
				a: 0,0,1,0,1,1,0,1
			}
			UVIndex: *4 {
				a: 0,1,2,3
			}
		}
	}
	Model: 20, "Model::body", "Mesh" {
		Properties70:  {
			P: "Lcl Scaling", "Lcl Scaling", "", "A",2,2,2
		}
	}
	Material: 30, "Material::cloth", "" {
	}
} ;end
Connections:  {
	C: "OO",10,20
	C: "OO",20,0
	C: "OO",30,20
}
)";
}

/// The square as version 6 writes it: objects named, lists without arrays, the mesh in its model.
inline std::string ascii_quad_fbx6(const std::string& in_mesh = "", const std::string& objects = "",
                                   const std::string& connections = "") {
  return "; FBX 6.1.0 project file\nFBXHeaderExtension:  {\n\tFBXVersion: 6100\n}\nObjects:  {\n"
         "\tModel: \"Model::body\", \"Mesh\" {\n\t\tVersion: 232\n\t\tProperties60:  {\n"
         "\t\t\tProperty: \"Lcl Scaling\", \"Lcl Scaling\", \"A+\",2,2,2\n" +
         in_mesh +
         "\t\t}\n\t\tVertices: 0,0,0,1,0,0,\n1,1,0\n\t\t  ,0,1,0\n\t\tPolygonVertexIndex: 0,1,2,-4\n"
         "\t\tLayerElementUV: 0 {\n\t\t\tMappingInformationType: \"ByPolygonVertex\"\n"
         "\t\t\tUV: 0,0,1,0,1,1,0,1\n\t\t\tUVIndex: 0,1,2,3\n\t\t}\n"
         "\t\tLayerElementMaterial: 0 {\n\t\t\tMappingInformationType: \"AllSame\"\n\t\t\tMaterials: "
         "0\n\t\t}\n"
         "\t\tShape: \"smile\" {\n\t\t\tIndexes: 1\n\t\t\tVertices: 0,0,1\n\t\t}\n\t}\n"
         "\tMaterial: \"Material::cloth\", \"\" {\n\t\tProperties60:  {\n"
         "\t\t\tProperty: \"DiffuseColor\", \"ColorRGB\", \"\",0.25,0.5,1\n\t\t}\n\t}\n" +
         objects +
         "\tGlobalSettings:  {\n\t\tProperties60:  {\n\t\t\tProperty: \"UnitScaleFactor\", \"double\", "
         "\"\",100\n"
         "\t\t}\n\t}\n}\nConnections:  {\n\tConnect: \"OO\", \"Model::body\", \"Model::Scene\"\n"
         "\tConnect: \"OO\", \"Material::cloth\", \"Model::body\"\n" +
         connections +
         "}\nTakes:  {\n\tTake: \"t\" {\n\t\tKey: \n\t\t\t1924423250,0.5,L,\n\t\t\t3848846500,1,L\n\t}\n}\n";
}

}  // namespace ohb
