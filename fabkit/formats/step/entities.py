"""Entities of STEP files other than solids, as blocks of text: header, units, products, placements, materials,
colours."""

from __future__ import annotations

from typing import Literal

from fabkit.formats.step.text import Block

__all__ = [
    "ASSEMBLY_BLOCK",
    "CONTEXT",
    "DEFINITION",
    "DENSITY_OFFSET",
    "FIRST_FREE_ID",
    "HEADER",
    "INSTANCE_BLOCK",
    "MATERIAL_BLOCK",
    "ORIGIN",
    "PART",
    "PLACED_BLOCK",
    "PLACEMENT_BLOCK",
    "PLACEMENT_OFFSET",
    "PRACTICE",
    "REPRESENTATION",
    "SCHEMAS",
    "STYLE_BLOCK",
    "Schema",
]

Schema = Literal["AP242", "AP214"]

SCHEMAS = {
    "AP242": (
        "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }",
        "managed model based 3d engineering",
        "'ap242_managed_model_based_3d_engineering',2014",
    ),
    "AP214": (
        "AUTOMOTIVE_DESIGN { 1 0 10303 214 3 1 1 }",
        "core data for automotive mechanical design processes",
        "'automotive_design',2010",
    ),
}
"""For each schema: its name in the header, the application, its protocol with the year."""

PRACTICE = "CAx-IF Rec.Pracs.---Geometric and Assembly Validation Properties---4.6---2023-04-21"
"""The recommended practice that the files follow, named in their headers."""

HEADER = """\
ISO-10303-21;
HEADER;
FILE_DESCRIPTION(('{name}','{practice}'),'2;1');
FILE_NAME('{name}','{time_stamp}',('{author}'),('{organisation}'),'fabkit','fabkit','');
FILE_SCHEMA(('{schema}'));
ENDSEC;
DATA;
#1=APPLICATION_CONTEXT('{application}');
#2=APPLICATION_PROTOCOL_DEFINITION('international standard',{protocol},#1);
#3=PRODUCT_CONTEXT('',#1,'mechanical');
#4=PRODUCT_DEFINITION_CONTEXT('part definition',#1,'design');
#5=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
#6=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
#7=(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT());
#8=UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({tolerance}),#5,'distance_accuracy_value','');
#9=CARTESIAN_POINT('',(0.,0.,0.));
#10=DIRECTION('',(0.,0.,1.));
#11=DIRECTION('',(1.,0.,0.));
#12=DERIVED_UNIT_ELEMENT(#5,3.);
#13=DERIVED_UNIT((#12));
#14=DERIVED_UNIT_ELEMENT(#5,2.);
#15=DERIVED_UNIT((#14));
#16=(MASS_UNIT()NAMED_UNIT(*)SI_UNIT($,.GRAM.));
#17=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.CENTI.,.METRE.));
#18=DERIVED_UNIT_ELEMENT(#16,1.);
#19=DERIVED_UNIT_ELEMENT(#17,-3.);
#20=DERIVED_UNIT((#18,#19));
#21=(GLOBAL_UNIT_ASSIGNED_CONTEXT((#5,#6,#7))REPRESENTATION_CONTEXT('',''));
"""
FIRST_FREE_ID = 22
"""Number of the first entity after those of the header."""

# Products. Their definition, shape representation and its origin have these numbers; each has a context of its own,
# since the two representations that a placement relates must not share one.
DEFINITION, REPRESENTATION, ORIGIN, CONTEXT = range(4)
_PRODUCT = (
    "PRODUCT_DEFINITION('design','',#<4>,#4)",
    "",
    "AXIS2_PLACEMENT_3D('',#9,#10,#11)",
    "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#8))"
    "GLOBAL_UNIT_ASSIGNED_CONTEXT((#5,#6,#7))REPRESENTATION_CONTEXT('',''))",
    "PRODUCT_DEFINITION_FORMATION('%s','',#<5>)",
    "PRODUCT('%s','%s','%s',(#3))",
    "PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#<5>))",
    "PRODUCT_DEFINITION_SHAPE('','',#<0>)",
    "SHAPE_DEFINITION_REPRESENTATION(#<7>,#<1>)",
)
PART = (
    *_PRODUCT[:REPRESENTATION],
    "ADVANCED_BREP_SHAPE_REPRESENTATION('',(#<2>,#<15>),#<3>)",
    *_PRODUCT[REPRESENTATION + 1 :],
    "PROPERTY_DEFINITION('material property','material name',#<0>)",
    "PROPERTY_DEFINITION_REPRESENTATION(#<9>,#%s)",
    "PROPERTY_DEFINITION('material property','density',#<0>)",
    "PROPERTY_DEFINITION_REPRESENTATION(#<11>,#%s)",
    "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',(#<14>),#<3>)",
    "STYLED_ITEM('color',(#%s),#<15>)",
    "MANIFOLD_SOLID_BREP('%s',#<22>)",
    # Validation properties, combined as in 4.12 of the practice named in the header.
    "PROPERTY_DEFINITION('geometric validation property','',#<7>)",
    "PROPERTY_DEFINITION_REPRESENTATION(#<16>,#<18>)",
    "REPRESENTATION('',(#<19>,#<20>,#<21>),#<3>)",
    "MEASURE_REPRESENTATION_ITEM('volume measure',VOLUME_MEASURE(%s),#13)",
    "MEASURE_REPRESENTATION_ITEM('surface area measure',AREA_MEASURE(%s),#15)",
    "CARTESIAN_POINT('centre point',(%s,%s,%s))",
)
"""A part's product, with material, density, colour and validation properties; the shell of its solid follows."""
ASSEMBLY_BLOCK = Block(_PRODUCT)

PLACEMENT_OFFSET = 3
"""Number of the placement entity within its block, from 0."""
_PLACEMENT = (
    "CARTESIAN_POINT('',(%s,%s,%s))",
    "DIRECTION('',(%s,%s,%s))",
    "DIRECTION('',(%s,%s,%s))",
    "AXIS2_PLACEMENT_3D('',#<0>,#<2>,#<1>)",
)
PLACEMENT_BLOCK = Block(_PLACEMENT)


def _instance(first: int, placement: str) -> tuple[str, ...]:
    """The entities of an instance after its placement; `first` is the number of the first of them in its block."""
    return (
        f"ITEM_DEFINED_TRANSFORMATION('','',#%s,{placement})",
        "(REPRESENTATION_RELATIONSHIP('','',#%s,#%s)"
        f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#<{first}>)SHAPE_REPRESENTATION_RELATIONSHIP())",
        "NEXT_ASSEMBLY_USAGE_OCCURRENCE('%s','%s','',#%s,#%s,$)",
        f"PRODUCT_DEFINITION_SHAPE('Placement','Placement of an item',#<{first + 2}>)",
        f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#<{first + 1}>,#<{first + 3}>)",
    )


INSTANCE_BLOCK = Block((*_PLACEMENT, *_instance(4, f"#<{PLACEMENT_OFFSET}>")))
"""An instance with a placement of its own."""
PLACED_BLOCK = Block(_instance(0, "#%s"))
"""An instance with a placement that was written before."""

MATERIAL_BLOCK = Block(
    (
        "REPRESENTATION('material name',(#<1>),#21)",
        "DESCRIPTIVE_REPRESENTATION_ITEM('%s','%s')",
        "REPRESENTATION('density',(#<3>),#21)",
        "MEASURE_REPRESENTATION_ITEM('density measure',POSITIVE_RATIO_MEASURE(%s),#20)",
    )
)
DENSITY_OFFSET = 2
"""Number of the density entity within the block of a material, from 0."""

STYLE_BLOCK = Block(
    (
        "PRESENTATION_STYLE_ASSIGNMENT((#<1>))",
        "SURFACE_STYLE_USAGE(.BOTH.,#<2>)",
        "SURFACE_SIDE_STYLE('',(#<3>))",
        "SURFACE_STYLE_FILL_AREA(#<4>)",
        "FILL_AREA_STYLE('',(#<5>))",
        "FILL_AREA_STYLE_COLOUR('',#<6>)",
        "COLOUR_RGB('',%s,%s,%s)",
    )
)
