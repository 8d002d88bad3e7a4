# A road with two cabins in the infrared: each object has one material, the include of the export computes its pixels.
extends Node3D

const LEVELS := Vector2(293.0, 317.0)  # apparent temperatures of black and white, K
# Godot's axes are east, up, south; those of the include east, north, up.
const SHADER := """
uniform vec3 to_source;
uniform int row;
uniform float ground;
uniform vec2 levels;
varying vec3 place;
varying vec3 side;

vec3 east_north_up(vec3 way) {
	return vec3(way.x, -way.z, way.y);
}

void vertex() {
	place = (MODEL_MATRIX * vec4(VERTEX, 1.0)).xyz;
	side = mat3(MODEL_MATRIX) * NORMAL;
}

void fragment() {
	SkyshineFace face;
	vec3 way = east_north_up(CAMERA_POSITION_WORLD - place);
	face.toObserver = normalize(way);
	face.toSource = to_source;
	face.normal = normalize(east_north_up(side));
	float slope = skyshineAngle(length(face.normal.xy), face.normal.z);
	float azimuth = skyshineAngle(face.normal.x, face.normal.y);
	SkyshineAirOfPixel air = skyshineAirAt(length(way) * 0.001, face.toObserver);
	float kelvin = skyshineTemperature(row, ground + place.y * 0.001, azimuth, slope);
	float radiance = skyshineSurfaceRadiance(air, row, kelvin, face) + skyshinePath(air, face);
	float white = clamp((skyshineApparentTemperature(radiance) - levels.x) / (levels.y - levels.x), 0.0, 1.0);
	ALBEDO = vec3(white); // the Compatibility renderer shows unshaded colours as they are
}
"""

var _shader := Shader.new()
var _frame := preload("res://skyshine.gd").new()


func _ready() -> void:
	_frame.load_frame("res://gpu")
	_shader.code = "shader_type spatial;\nrender_mode unshaded, cull_disabled;\n" + _frame.include + SHADER
	_add(_plane(4000, 4000), "grass_green", Vector3.ZERO, 0.0)
	_add(_plane(12, 4000), "asphalt_road", Vector3(0, 0.3, 0), -0.3)
	for place in [Vector3(-40, 6, -10), Vector3(45, 6, 30)]:
		var box := BoxMesh.new()
		box.size = Vector3(30, 12, 18)
		_add(box, "wood_pine_weathered", place, 0.4)
	for k in 60:
		var east := float((k * 97) % 400) - 200.0
		var north := float((k * 61) % 380) - 120.0
		var clear := absf(east - 0.31 * north) > 25.0
		if clear and Vector2(east + 40, north - 10).length() > 35 and Vector2(east - 45, north + 30).length() > 35:
			var cone := CylinderMesh.new()
			cone.top_radius = 0.0
			cone.bottom_radius = 6.0
			cone.height = 18.0
			_add(cone, "conifer", Vector3(east, 9, -north), 0.0)
	# The air of the frame is that of its altitude: the camera keeps it.
	var camera := Camera3D.new()
	camera.fov = 18.0
	camera.near = 10.0
	camera.far = 20000.0
	add_child(camera)
	camera.look_at_from_position(Vector3(250, _frame.height_m, 500), Vector3(0, 0, -20))


func _plane(width: float, length: float) -> PlaneMesh:
	var plane := PlaneMesh.new()
	plane.size = Vector2(width, length)
	return plane


func _add(mesh: Mesh, material: String, place: Vector3, turn: float) -> void:
	var shader_material := ShaderMaterial.new()
	shader_material.shader = _shader
	for name in _frame.parameters:
		shader_material.set_shader_parameter(name, _frame.parameters[name])
	shader_material.set_shader_parameter("to_source", _frame.to_source)
	shader_material.set_shader_parameter("row", _frame.materials.find(material))
	shader_material.set_shader_parameter("ground", _frame.ground_km)
	shader_material.set_shader_parameter("levels", LEVELS)
	var instance := MeshInstance3D.new()
	instance.mesh = mesh
	instance.material_override = shader_material
	instance.position = place
	instance.rotation.y = turn
	add_child(instance)
