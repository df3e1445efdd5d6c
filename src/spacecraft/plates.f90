!> A satellite's outside as flat plates.
module gracecg_spacecraft_plates
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: integer_text
    implicit none
    private
    public :: plate_t, satellite_surface_t, surface_of, new_surface, new_trapezoid, &
        projected_area, MAX_PLATES, REPORT_PRISM

    real(dp), parameter :: REPORT_PRISM(4) = [3.122_dp, 0.720_dp, 1.942_dp, 0.693_dp]
    !! Length, height, width at the bottom and at the top of the satellites of CSR-TM-00-01 section 5.2, m
    !> Greatest number of plates of a surface, a multiple of LANES
    integer, parameter :: MAX_PLATES = 32
    real(dp), parameter :: UNIT_TOLERANCE = 1e-9_dp     !! Of the length of a normal
    real(dp), parameter :: CLOSURE_TOLERANCE = 1e-6_dp
    !! Of the sum of normal times area, relative to the total area

    type :: plate_t
        !! One flat side of the satellite; body axes
        real(dp) :: normal(3) = 0     !! n, unit vector outwards
        real(dp) :: area = 0          !! S, m^2
        real(dp) :: centre(3) = 0     !! Centroid, from the origin of the surface's own frame, m
        real(dp) :: specular = 0      !! Part of the light that is reflected as by a mirror
        real(dp) :: diffuse = 0       !! Part that is scattered after Lambert, the rest absorbed
    end type plate_t

    type :: satellite_surface_t
        !! A closed convex body: its plates side by side, see `plate_t`; from `count` on their areas are 0
        integer :: count = 0                        !! Number of the plates
        real(dp) :: normal(MAX_PLATES, 3) = 0       !! Plate, axis
        real(dp) :: area(MAX_PLATES) = 0            !! m^2
        real(dp) :: centre(MAX_PLATES, 3) = 0       !! Plate, axis
        real(dp) :: specular(MAX_PLATES) = 0        !! Part of the light that is reflected specularly
        real(dp) :: diffuse(MAX_PLATES) = 0         !! Part that is reflected diffusely
    contains
        procedure :: plate  !! One of the plates
    end type satellite_surface_t

contains

    !> The trapezoidal prism of GRACE, CSR-TM-00-01 eq. (2-7), with the plates in its order:
    !> front, rear, the sides towards +y and -y, bottom, top. x points along the length, z to the
    !> bottom, the wide side that faces the Earth. The origin of the plates' centres is on the
    !> axis of symmetry at half the length and half the height. (The report prints sin a and cos a
    !> as the sine and cosine of h/sqrt(c^2+h^2) and c/sqrt(c^2+h^2); they are those quotients
    !> themselves.)
    !>
    !> Fails when a dimension is not positive or a reflectivity is not a part of 1.
    subroutine new_trapezoid(length, height, width_bottom, width_top, specular, diffuse, self, error)
        type(satellite_surface_t), intent(out) :: self
        real(dp), intent(in) :: length, height              !! m
        real(dp), intent(in) :: width_bottom, width_top     !! m
        real(dp), intent(in) :: specular, diffuse           !! Of every plate, see plate_t
        type(error_t), allocatable, intent(out) :: error

        type(plate_t) :: plates(6)
        real(dp) :: mean_width, overhang, slant, sin_a, cos_a, end_centre

        if (.not. all([length, height, width_bottom, width_top] > 0)) then
            call fail(error, 'trapezoid: length, height, width_bottom and width_top have to be '// &
                      'positive, but one is '// &
                      number_text(min(length, height, width_bottom, width_top))//' m')
            return
        end if
        mean_width = (width_bottom + width_top)/2
        overhang = (width_bottom - width_top)/2             ! c of eq. (2-7)
        slant = hypot(overhang, height)
        sin_a = height/slant
        cos_a = overhang/slant
        end_centre = height*(width_bottom - width_top)/(12*mean_width)

        plates%specular = specular
        plates%diffuse = diffuse
        plates(1)%normal = [1.0_dp, 0.0_dp, 0.0_dp]
        plates(2)%normal = [-1.0_dp, 0.0_dp, 0.0_dp]
        plates(3)%normal = [0.0_dp, sin_a, -cos_a]
        plates(4)%normal = [0.0_dp, -sin_a, -cos_a]
        plates(5)%normal = [0.0_dp, 0.0_dp, 1.0_dp]
        plates(6)%normal = [0.0_dp, 0.0_dp, -1.0_dp]
        plates(1:2)%area = mean_width*height
        plates(3:4)%area = length*height/sin_a
        plates(5)%area = width_bottom*length
        plates(6)%area = width_top*length
        plates(1)%centre = [length/2, 0.0_dp, end_centre]
        plates(2)%centre = [-length/2, 0.0_dp, end_centre]
        plates(3)%centre = [0.0_dp, mean_width/2, 0.0_dp]
        plates(4)%centre = [0.0_dp, -mean_width/2, 0.0_dp]
        plates(5)%centre = [0.0_dp, 0.0_dp, height/2]
        plates(6)%centre = [0.0_dp, 0.0_dp, -height/2]
        call new_surface(plates, self, error)
    end subroutine new_trapezoid

    !> A surface of any plates. Fails when there are too many, when a number is not finite, an area
    !> not positive, a normal not of length one, a reflectivity not a part of 1, or when the
    !> plates leave a gap: the sum of normal times area of a closed body is zero.
    subroutine new_surface(plates, self, error)
        type(satellite_surface_t), intent(out) :: self
        type(plate_t), intent(in) :: plates(:)
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: gap(3)
        integer :: i

        if (size(plates) < 1 .or. size(plates) > MAX_PLATES) then
            call fail(error, 'satellite surface: '//integer_text(size(plates))// &
                      ' plates given, 1 to '//integer_text(MAX_PLATES)//' allowed')
            return
        end if
        gap = 0
        do i = 1, size(plates)
            call check_plate(plates(i), i, error)
            if (allocated(error)) return
            gap = gap + plates(i)%area*plates(i)%normal
        end do
        if (norm2(gap) > CLOSURE_TOLERANCE*sum(plates%area)) then
            call fail(error, 'satellite surface: the plates do not close; the sum of normal '// &
                      'times area should be zero but is '//number_text(norm2(gap))//' m^2 long')
            return
        end if
        self = surface_of(plates)
    end subroutine new_surface

    !> A surface of any plates, unchecked: parts of a body.
    pure function surface_of(plates) result(surface)
        type(plate_t), intent(in) :: plates(:)      !! At most MAX_PLATES
        type(satellite_surface_t) :: surface

        integer :: i

        surface%count = size(plates)
        do i = 1, size(plates)
            surface%normal(i, :) = plates(i)%normal
            surface%area(i) = plates(i)%area
            surface%centre(i, :) = plates(i)%centre
            surface%specular(i) = plates(i)%specular
            surface%diffuse(i) = plates(i)%diffuse
        end do
    end function surface_of

    pure type(plate_t) function plate(self, i)
        class(satellite_surface_t), intent(in) :: self
        integer, intent(in) :: i        !! 1 to `count`

        plate = plate_t(self%normal(i, :), self%area(i), self%centre(i, :), self%specular(i), self%diffuse(i))
    end function plate

    subroutine check_plate(plate, number, error)
        type(plate_t), intent(in) :: plate
        integer, intent(in) :: number           !! For the message
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: name

        name = 'plate '//integer_text(number)//' of the satellite surface: '
        if (.not. (plate%area > 0 .and. ieee_is_finite(plate%area))) then
            call fail(error, name//'area = '//number_text(plate%area)//' m^2 has to be positive')
        else if (.not. abs(norm2(plate%normal) - 1) < UNIT_TOLERANCE) then
            call fail(error, name//'the normal has to have length 1 but has '// &
                      number_text(norm2(plate%normal)))
        else if (.not. all(ieee_is_finite(plate%centre))) then
            call fail(error, name//'the centre is not a finite number')
        else if (.not. (plate%specular >= 0 .and. plate%diffuse >= 0 .and. &
                        plate%specular + plate%diffuse <= 1)) then
            call fail(error, name//'specular = '//number_text(plate%specular)//' and diffuse = '// &
                      number_text(plate%diffuse)//' have to lie in 0 to 1, and so has their sum')
        end if
    end subroutine check_plate

    !> Cross-section of the body seen from a direction, m^2: CSR-TM-00-01 eqs. (2-7), (2-9),
    !> (2-15) with the plates that face the observer. (So is (2-15) printed; the other two run over
    !> those turned away, which for a closed body is the same.)
    pure real(dp) function projected_area(self, direction) result(area)
        type(satellite_surface_t), intent(in) :: self
        real(dp), intent(in) :: direction(3)    !! Unit vector towards the observer, body axes

        integer :: i

        area = 0
        do i = 1, self%count
            area = area + self%area(i)*max(0.0_dp, dot_product(self%normal(i, :), direction))
        end do
    end function projected_area
end module gracecg_spacecraft_plates
