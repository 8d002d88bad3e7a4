"""Pictures of a scene from built databases: a surface, a camera, the radiance of every pixel by hour and band."""
