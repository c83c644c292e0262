//! A picture to which the elements of a drawing are added.
//!
//! It knows the elements and attributes that the figures and maps of this crate have. An element or
//! attribute that it does not know is an error, not left out.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use roxmltree::Node;
use tiny_skia::{
    Color, FillRule, FilterQuality, GradientStop, LineJoin, LinearGradient, Paint, Path,
    PathBuilder, Pattern, Pixmap, Point, Rect, Shader, SpreadMode, Stroke, StrokeDash, Transform,
};

use super::allowed::{require_known, require_root, require_value};
use super::attribute::{SVG, attribute, number, optional_number, unknown_part};
use super::fault::PngError;
use super::glyphs::TextOutline;
use super::path_data::{numbers, path};

/// A picture in progress.
pub(super) struct PixelCanvas<'s> {
    pub(super) pixmap: Pixmap,
    /// The way from the pixels of the drawing to those of the picture.
    transform: Transform,
    root: Node<'s, 's>,
}

impl<'s> PixelCanvas<'s> {
    /// Begins a white picture of a drawing whose root is given; `scale` is the number of its pixels
    /// for one of the drawing. There is none if it would have no pixel.
    ///
    /// # Errors
    /// [`PngError::Unknown`], if the root has an attribute that figures and maps do not have.
    pub(super) fn new(
        root: Node<'s, 's>,
        (width, height): (u32, u32),
        scale: f32,
    ) -> Result<Option<Self>, PngError> {
        require_root(root)?;
        if let Some(fill) = root.attribute("fill") {
            color(fill, 1.0)?;
        }
        let Some(mut pixmap) = Pixmap::new(width, height) else { return Ok(None) };
        pixmap.fill(Color::WHITE);
        Ok(Some(PixelCanvas { pixmap, transform: Transform::from_scale(scale, scale), root }))
    }

    /// Adds an element.
    ///
    /// # Errors
    /// [`PngError::Unknown`], if it is none that figures and maps have.
    pub(super) fn add(&mut self, node: Node<'_, '_>) -> Result<(), PngError> {
        require_known(node)?;
        let place = |x: &str, y: &str| Ok::<_, PngError>((number(node, x)?, number(node, y)?));
        let mut lines = PathBuilder::new();
        let outline = match node.tag_name().name() {
            "title" => return Ok(()),
            "defs" => return node.children().filter(Node::is_element).try_for_each(gradient),
            "image" => return self.image(node),
            "text" => return self.text(node),
            "path" => path(attribute(node, "d")?).map_err(unknown_part)?,
            "rect" => frame(node)?.map(PathBuilder::from_rect),
            "circle" => {
                let (x, y) = place("cx", "cy")?;
                PathBuilder::from_circle(x, y, number(node, "r")?)
            }
            "line" => {
                let ((x1, y1), (x2, y2)) = (place("x1", "y1")?, place("x2", "y2")?);
                lines.move_to(x1, y1);
                lines.line_to(x2, y2);
                lines.finish()
            }
            "polygon" => {
                let points = format!("M{}Z", attribute(node, "points")?);
                path(&points).map_err(unknown_part)?
            }
            other => return Err(unknown_part(format!("an element `{other}`"))),
        };
        match outline {
            Some(outline) => self.shape(node, &outline, self.transform),
            None => Ok(()),
        }
    }

    /// Fills and strokes an outline as its element says.
    fn shape(
        &mut self,
        node: Node<'_, '_>,
        outline: &Path,
        transform: Transform,
    ) -> Result<(), PngError> {
        require_value(node, "paint-order", "stroke")?;
        let strokes_first = node.has_attribute("paint-order");
        if strokes_first {
            self.stroke(node, outline, transform)?;
        }
        self.fill(node, outline, transform)?;
        if !strokes_first {
            self.stroke(node, outline, transform)?;
        }
        Ok(())
    }

    fn fill(
        &mut self,
        node: Node<'_, '_>,
        outline: &Path,
        transform: Transform,
    ) -> Result<(), PngError> {
        let fill = node.attribute("fill").or(self.root.attribute("fill")).unwrap_or("#000000");
        let opacity = optional_number(node, "fill-opacity", 1.0)?;
        let bounds = outline.bounds();
        // A line has nothing inside.
        if bounds.width() > 0.0
            && bounds.height() > 0.0
            && let Some(shader) = self.shader(fill, opacity, bounds)?
        {
            let paint = Paint { shader, ..Paint::default() };
            self.pixmap.fill_path(outline, &paint, FillRule::Winding, transform, None);
        }
        Ok(())
    }

    fn stroke(
        &mut self,
        node: Node<'_, '_>,
        outline: &Path,
        transform: Transform,
    ) -> Result<(), PngError> {
        let color = node.attribute("stroke").unwrap_or("none");
        let Some(shader) = self.shader(color, 1.0, outline.bounds())? else { return Ok(()) };
        let line_join = match node.attribute("stroke-linejoin") {
            None => LineJoin::Miter,
            Some("round") => LineJoin::Round,
            Some(other) => return Err(unknown_part(format!("a corner `{other}`"))),
        };
        let dash = match node.attribute("stroke-dasharray") {
            None => None,
            Some(text) => match numbers(text) {
                Some((mut lengths, "")) => {
                    if lengths.len() % 2 == 1 {
                        lengths.extend_from_within(..);
                    }
                    StrokeDash::new(lengths, 0.0)
                }
                _ => return Err(unknown_part(format!("dashes `{text}`"))),
            },
        };
        let width = optional_number(node, "stroke-width", 1.0)?;
        let stroke = Stroke { width, line_join, dash, ..Stroke::default() };
        if width > 0.0 {
            let paint = Paint { shader, ..Paint::default() };
            self.pixmap.stroke_path(outline, &paint, &stroke, transform, None);
        }
        Ok(())
    }

    /// Returns what a colour, or the name of a gradient over the bounds, paints with; `None` if it
    /// paints nothing.
    fn shader(
        &self,
        paint: &str,
        opacity: f32,
        bounds: Rect,
    ) -> Result<Option<Shader<'static>>, PngError> {
        if matches!(paint, "none" | "transparent") {
            return Ok(None);
        }
        let Some(name) = paint.strip_prefix("url(#").and_then(|name| name.strip_suffix(')')) else {
            return Ok(Some(Shader::SolidColor(color(paint, opacity)?)));
        };
        let mut gradients =
            self.root.descendants().filter(|node| node.has_tag_name((SVG, "linearGradient")));
        let Some(gradient) = gradients.find(|node| node.attribute("id") == Some(name)) else {
            return Err(unknown_part(format!("no gradient `{name}`")));
        };
        let mut stops = Vec::new();
        for stop in gradient.children().filter(|node| node.has_tag_name((SVG, "stop"))) {
            let color = color(attribute(stop, "stop-color")?, opacity)?;
            stops.push(GradientStop::new(number(stop, "offset")?, color));
        }
        // The ends are fractions of the bounds.
        let end = |x: &str, y: &str| {
            Ok::<_, PngError>(Point::from_xy(number(gradient, x)?, number(gradient, y)?))
        };
        let over =
            Transform::from_row(bounds.width(), 0.0, 0.0, bounds.height(), bounds.x(), bounds.y());
        Ok(LinearGradient::new(end("x1", "y1")?, end("x2", "y2")?, stops, SpreadMode::Pad, over))
    }

    fn text(&mut self, node: Node<'_, '_>) -> Result<(), PngError> {
        let (x, y) = (number(node, "x")?, number(node, "y")?);
        // As in XML, blanks are one where several meet.
        let words: Vec<&str> =
            node.text().unwrap_or("").split(' ').filter(|w| !w.is_empty()).collect();
        let line = TextOutline::new(&words.join(" "), number(node, "font-size")?);
        let start = match node.attribute("text-anchor") {
            None | Some("start") => x,
            Some("middle") => x - line.width / 2.0,
            Some("end") => x - line.width,
            Some(other) => {
                return Err(unknown_part(format!("a text that stands at its `{other}`")));
            }
        };
        let turned = match node.attribute("transform") {
            None => self.transform,
            Some(transform) => {
                let rotation = transform.strip_prefix("rotate(").and_then(|t| t.strip_suffix(')'));
                match rotation.and_then(numbers) {
                    Some((parts, "")) if parts.len() == 3 => self
                        .transform
                        .pre_concat(Transform::from_rotate_at(parts[0], parts[1], parts[2])),
                    _ => return Err(unknown_part(format!("a transform `{transform}`"))),
                }
            }
        };
        match line.path {
            Some(outline) => self.shape(node, &outline, turned.pre_translate(start, y)),
            None => Ok(()),
        }
    }

    /// Adds a picture inside the drawing, whose pixels stay sharp.
    fn image(&mut self, node: Node<'_, '_>) -> Result<(), PngError> {
        require_value(node, "preserveAspectRatio", "none")?;
        require_value(node, "image-rendering", "optimizeSpeed")?;
        let Some(frame) = frame(node)? else { return Ok(()) };
        let link = node.attributes().find(|attribute| attribute.name() == "href");
        let link = link.map_or("", |attribute| attribute.value());
        let inner = link
            .strip_prefix("data:image/png;base64,")
            .and_then(|data| BASE64_STANDARD.decode(data).ok())
            .and_then(|data| Pixmap::decode_png(&data).ok())
            .ok_or_else(|| unknown_part("an image that is no PNG inside the figure"))?;
        let size = (inner.width() as f32, inner.height() as f32);
        let Some(whole) = Rect::from_xywh(0.0, 0.0, size.0, size.1) else { return Ok(()) };
        let shader = Pattern::new(
            inner.as_ref(),
            SpreadMode::Pad,
            FilterQuality::Nearest,
            1.0,
            Transform::default(),
        );
        let paint = Paint { shader, ..Paint::default() };
        let onto = Transform::from_row(
            frame.width() / size.0,
            0.0,
            0.0,
            frame.height() / size.1,
            frame.x(),
            frame.y(),
        );
        self.pixmap.fill_rect(whole, &paint, self.transform.pre_concat(onto), None);
        Ok(())
    }
}

/// Checks a gradient and its stops; it is drawn where a shape names it.
fn gradient(node: Node<'_, '_>) -> Result<(), PngError> {
    require_known(node)?;
    if !node.has_tag_name((SVG, "linearGradient")) {
        return Err(unknown_part(format!("an element `{}` in `defs`", node.tag_name().name())));
    }
    for stop in node.children().filter(Node::is_element) {
        require_known(stop)?;
        if !stop.has_tag_name((SVG, "stop")) {
            let name = stop.tag_name().name();
            return Err(unknown_part(format!("an element `{name}` in `linearGradient`")));
        }
    }
    Ok(())
}

/// Returns the rectangle of an element, unless it is empty.
fn frame(node: Node<'_, '_>) -> Result<Option<Rect>, PngError> {
    let (width, height) = (number(node, "width")?, number(node, "height")?);
    Ok(match width > 0.0 && height > 0.0 {
        true => Rect::from_xywh(
            optional_number(node, "x", 0.0)?,
            optional_number(node, "y", 0.0)?,
            width,
            height,
        ),
        false => None,
    })
}

/// Reads a colour such as `#1a1a1a`.
fn color(text: &str, opacity: f32) -> Result<Color, PngError> {
    let channel = |i: usize| u8::from_str_radix(text.get(i..i + 2)?, 16).ok();
    let channels = match text.strip_prefix('#') {
        Some(digits) if digits.len() == 6 => channel(1).zip(channel(3)).zip(channel(5)),
        _ => None,
    };
    let Some(((red, green), blue)) = channels else {
        return Err(unknown_part(format!("a colour `{text}`")));
    };
    Ok(Color::from_rgba8(red, green, blue, (opacity * 255.0).round() as u8))
}
