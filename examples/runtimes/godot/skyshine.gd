# Textures and numbers of one frame of `mat export FOLDER --to gpu --hour HOUR --altitude KM`, as parameters of a shader.
extends RefCounted

const FORMATS := {
	"R16F": [Image.FORMAT_RH, 2], "RGBA16F": [Image.FORMAT_RGBAH, 8],
	"R32F": [Image.FORMAT_RF, 4], "RGBA32F": [Image.FORMAT_RGBAF, 16],
}

var parameters := {}  # of the shader, by name
var include := ""  # source of the include, in Godot's shading language
var materials: Array = []  # names, by row
var to_source := Vector3.ZERO  # east, north, up
var ground_km := 0.0
var height_m := 0.0  # of the camera above the ground
var _headers := {}
var _bytes := {}


func load_frame(folder: String, state := "s01", band := "b02", source := "") -> void:
	var air := _open(folder, "%s%s.%satmq" % [state, band, source])
	var glow := _open(folder, band + ".band")
	var surface := _open(folder, state + ".htt")
	var groups := int(air.components) / 4
	for k in 4:
		parameters["skyshineAir%d" % k] = _solid(air, "air%d" % mini(k, groups - 1))
	parameters.skyshineNodes = _nodes(air, surface)
	parameters.skyshineTerms = _terms(air, groups)
	parameters.skyshineBlackbody = _flat(glow, "blackbody")
	parameters.skyshineMaterials = _flat(glow, "materials")
	parameters.skyshineTemperatures = _solid(surface, "temperature")
	parameters.skyshineReference = _flat(surface, "reference")
	parameters.skyshineShadedChange = parameters.skyshineTemperatures  # this example draws no shade
	parameters.skyshineShaded = Vector2i(1, 1)
	parameters.skyshineSize = Vector4i(air.axes[0].size(), air.axes[1].size(), air.axes[2].size(), groups)
	parameters.skyshineCount = Vector4i(air.material.size(), air.emission_temperature.size(), 1 + air.harmonic.size(), air.angle.size())
	var repeats := 1 if surface.azimuth_repeats else 0
	parameters.skyshineSurface = Vector4i(surface.azimuth.size(), surface.slope.size(), surface.altitude.size(), repeats)
	parameters.skyshineObserver = _observer(air)
	parameters.skyshineBand = Vector3(glow.first_temperature, glow.temperature_step, glow.temperatures)
	materials = surface.material_name
	ground_km = surface.altitude[0]
	height_m = 1000.0 * parameters.skyshineObserver.x
	var up := deg_to_rad(air.source_elevation.path[0])
	var along := deg_to_rad(air.source_azimuth)
	to_source = Vector3(cos(up) * sin(along), cos(up) * cos(along), sin(up))
	include = _translated(FileAccess.get_file_as_string(folder + "/skyshine.glsl"))


# The include in Godot's language: without statements of precision, with filters beside the textures.
func _translated(text: String) -> String:
	var lines := PackedStringArray()
	for line in text.split("\n"):
		if line.begins_with("precision"):
			continue
		if line.begins_with("uniform sampler"):
			var linear := line.contains("sampler3D")
			line = line.get_slice(";", 0) + (" : filter_linear, repeat_disable;" if linear else " : filter_nearest, repeat_disable;")
		lines.append(line)
	return "\n".join(lines)


func _open(folder: String, name: String) -> Dictionary:
	var path := "%s/%s.gpu" % [folder, name]
	if not FileAccess.file_exists(path + ".json"):
		push_error(path + ".json: is missing; write it with 'mat export --to gpu'")
	var header: Dictionary = JSON.parse_string(FileAccess.get_file_as_string(path + ".json"))
	var numbers: Dictionary = header.numbers
	numbers.file = name
	_headers[name] = header.textures
	_bytes[name] = FileAccess.get_file_as_bytes(path + ".bin")
	return numbers


func _part(file: Dictionary, part: String) -> PackedByteArray:
	var entry: Dictionary = _headers[file.file][part]
	return _bytes[file.file].slice(int(entry.offset), int(entry.offset) + int(entry.bytes))


func _flat(file: Dictionary, part: String) -> ImageTexture:
	var entry: Dictionary = _headers[file.file][part]
	return _texture(_part(file, part), int(entry.size[0]), int(entry.size[1]), FORMATS[entry.format][0])


func _texture(bytes: PackedByteArray, width: int, height: int, format: int) -> ImageTexture:
	return ImageTexture.create_from_image(Image.create_from_data(width, height, false, format, bytes))


func _solid(file: Dictionary, part: String) -> ImageTexture3D:
	var entry: Dictionary = _headers[file.file][part]
	var width := int(entry.size[0])
	var height := int(entry.size[1])
	var layer: int = width * height * FORMATS[entry.format][1]
	var bytes := _part(file, part)
	var images: Array[Image] = []
	for k in int(entry.size[2]):
		images.append(Image.create_from_data(width, height, false, FORMATS[entry.format][0], bytes.slice(k * layer, (k + 1) * layer)))
	var made := ImageTexture3D.new()
	made.create(FORMATS[entry.format][0], width, height, images.size(), false, images)
	return made


# Nodes of the axes, one a row, in the order of the include.
func _nodes(air: Dictionary, surface: Dictionary) -> ImageTexture:
	var axes := [air.axes[0], air.axes[1], air.emission_temperature, air.angle, surface.azimuth, surface.slope, surface.altitude]
	var width := 0
	for axis in axes:
		width = maxi(width, axis.size())
	var values := PackedFloat32Array()
	values.resize(width * axes.size())
	for row in axes.size():
		for k in axes[row].size():
			values[row * width + k] = axes[row][k]
	return _texture(values.to_byte_array(), width, axes.size(), Image.FORMAT_RF)


func _terms(air: Dictionary, groups: int) -> ImageTexture:
	var bytes := PackedByteArray()
	for part in ["emission", "thermal_path", "path", "sky", "direct"]:
		bytes.append_array(_part(air, part))
	return _texture(bytes, groups, bytes.size() / (16 * groups), Image.FORMAT_RGBAF)


# Height above the ground, effective radius, scale height (km), and the texture coordinate of the altitude.
func _observer(air: Dictionary) -> Vector4:
	var height: float = air.altitude_km[0] - air.ground_altitude_km
	var root := pow(height, 1.0 / 3.0)
	var nodes: Array = air.height_root
	var lower := 0
	while lower < nodes.size() - 2 and nodes[lower + 1] <= root:
		lower += 1
	var weight := clampf((root - nodes[lower]) / (nodes[lower + 1] - nodes[lower]), 0.0, 1.0)
	return Vector4(height, lerpf(air.effective_radius[lower], air.effective_radius[lower + 1], weight), air.scale_height_km, 0.5)
