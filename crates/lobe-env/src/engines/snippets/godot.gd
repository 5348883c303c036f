# The light of a sky for Godot 4, written by lobe {{version}}. README.md says what the folder holds. By the formulas of
# Godot's source: this script was not run.
#
# Copy the folder into a project, and attach this script to a WorldEnvironment.
extends WorldEnvironment

# Radiance over pi, nine colors, as light probes have them.
const COEFFICIENTS := [
    {{coefficients}}
]

# Suns: the direction towards each, the irradiance of a surface that faces it, the diameter of its disc in degrees.
const SUNS := {{suns}}


func _ready() -> void:
	var material := PanoramaSkyMaterial.new()
	var folder: String = (get_script() as Script).resource_path.get_base_dir()
	material.panorama = load(folder.path_join("light.hdr"))
	var sky := Sky.new()
	sky.sky_material = material
	environment = Environment.new()
	environment.background_mode = Environment.BG_SKY
	environment.sky = sky
	environment.ambient_light_source = Environment.AMBIENT_SOURCE_SKY
	environment.reflected_light_source = Environment.REFLECTION_SOURCE_SKY
	for sun in SUNS:
		add_child(_sun_light(sun))


func _sun_light(sun: Dictionary) -> DirectionalLight3D:
	var d := Vector3(sun.direction[0], sun.direction[1], sun.direction[2])
	var e := Vector3(sun.irradiance[0], sun.irradiance[1], sun.irradiance[2])
	var brightest: float = max(e.x, max(e.y, e.z))
	var light := DirectionalLight3D.new()
	# Colors of lights are those of displays; Godot makes them linear.
	light.light_color = Color(e.x / brightest, e.y / brightest, e.z / brightest).linear_to_srgb()
	light.light_energy = brightest / PI
	light.light_angular_distance = sun.diameter / 2.0
	var up := Vector3.UP if absf(d.y) < 0.99 else Vector3.RIGHT
	light.basis = Basis.looking_at(-d, up)
	return light
