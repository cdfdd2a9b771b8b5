export { Color, CylinderGeometry, DirectionalLight, HemisphereLight, InstancedMesh, Matrix4, MeshLambertMaterial, PerspectiveCamera, Quaternion, Scene, SphereGeometry, Vector3, WebGLRenderer, Box3, Mesh } from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
