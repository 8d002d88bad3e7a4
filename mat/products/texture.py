"""The ``.tmm`` database of one texture."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from skyshine.mat.products.product import Context, TaskReport
from skyshine.tmm.job.model import TextureJob
from skyshine.tmm.mapping.texture_map import TextureMap, map_texture
from skyshine.tmm.mapping.write import is_current, write_texture


@dataclass(frozen=True)
class TextureIdentity:
    """The database of a texture: its job, its image and seeds, and the library.

    Attributes
    ----------
    job_folder : Path
        Folder to which the paths of the job are relative.
    """

    file: str
    job: TextureJob
    job_folder: Path
    library_version: str

    def is_current(self, folder: Path) -> bool:
        """Whether the file is there, undamaged, from the same job, image, seeds and library."""
        return is_current(folder / self.file, self.job, self.job_folder, self.library_version)

    def write(self, folder: Path, content: TextureMap) -> None:
        """Classify the texture into the file, band by band."""
        write_texture(content, folder / self.file)

    def draw(self, folder: Path, picture: Path) -> None:
        """Draw the codes beside the photograph."""
        from skyshine.tmm.report.preview import draw

        draw(folder / self.file, picture, self.job_folder / self.job.image)

    def error_kelvin(self, content: object) -> None:
        """A classification errs in materials, not in kelvin."""
        return


class TextureProduct:
    """Material codes of a texture."""

    def identity(self, context: Context) -> tuple[TextureIdentity, ...]:
        """The one file of a texture."""
        task, loaded = context.task, context.loaded
        job = loaded.trimmed.texture_jobs[task.index]
        return (TextureIdentity(task.files[0], job, loaded.folder, context.library.version),)

    def compute(self, context: Context, report: TaskReport) -> Iterator[TextureMap]:
        """Train the classifier; its writing classifies."""
        (identity,) = self.identity(context)
        with report.stage("train"):
            texture = map_texture(identity.job, identity.job_folder, context.library)
        if texture.quality.quality.tested:
            report.notes.append(f"held-out seeds: accuracy {texture.quality.quality.overall_accuracy:.3f}")
        yield texture
