!> Sunlight reflected and heat emitted by the Earth, as a satellite receives them, after Knocke.
!>
!> CSR-TM-00-01 section 2.3.2.3; P. C. Knocke, J. C. Ries, B. D. Tapley, AIAA 88-4292, 1988; P. C.
!> Knocke, dissertation, The University of Texas at Austin, 1989. The part of the Earth that the
!> satellite sees is cut into a cap about the subsatellite point and rings around it. All segments
!> have the same projected, attenuated area A' = (solid angle of the segment at the satellite)/pi.
!> Albedo and emissivity are zonal harmonics of degree 2 with a yearly term, taken at the
!> segment's centre.
module gracecg_environment_earth_radiation
    use gracecg_base_kinds, only: dp
    use gracecg_base_lanes, only: LANES, lanes_of, total_of
    use gracecg_base_constants, only: TWO_PI, ASTRONOMICAL_UNIT, EARTH_RADIUS_EGM96
    use gracecg_base_error, only: error_t, fail, fail_out_of_range, fail_unknown_name
    use gracecg_base_text, only: integer_text
    use gracecg_base_vectors, only: transformed, transformed_back
    use gracecg_environment_table_earth_radiation, only: REPORT_ALBEDO, REPORT_EMISSIVITY, KNOCKE_ALBEDO, &
        KNOCKE_EMISSIVITY, PERIOD_DAYS, EPOCH_JD, SOLAR_IRRADIANCE_1AU
    implicit none
    private
    public :: earth_radiation_t, earth_irradiance_t, new_earth_radiation, standard_rings
    public :: MAX_SEGMENTS, MAX_RINGS, EARTH_RADIATION_EPOCH_JD, DEFAULT_SOLAR_IRRADIANCE
    public :: EARTH_RADIATION_CONSTANTS, SEGMENT_CENTRES

    !> Names of the sets of constants
    character(20), parameter :: EARTH_RADIATION_CONSTANTS(3) = [character(20) :: 'report', 'knocke', &
                                                                'constant-emissivity']
    !> Names of the places of a ring's centres between its edges: half-way in the angle at the Earth's centre, the
    !> reading of CSR-TM-00-01 whose curves lie in its printed windows; or where the ring's solid angle is halved, which
    !> is the better sum: 19 segments are 0.6 % RMS off the integral over the visible cap, those of mid-angle 12 %
    character(16), parameter :: SEGMENT_CENTRES(2) = [character(16) :: 'mid-angle', 'half-solid-angle']
    integer, parameter :: MAX_SEGMENTS = 169    !! The cap and seven rings of 6, 12 ... 42
    !> Greatest number of rings
    integer, parameter :: MAX_RINGS = 16
    real(dp), parameter :: EARTH_RADIATION_EPOCH_JD = EPOCH_JD
    !! t0 of eqs. (2-13), (2-14) as a Julian date, UTC
    real(dp), parameter :: DEFAULT_SOLAR_IRRADIANCE = SOLAR_IRRADIANCE_1AU
    !! W/m^2 at 1 au; CSR-TM-00-01 gives no figure
    real(dp), parameter :: ABSORBED_TO_EMITTED = 0.25_dp
    !! M_B/E_s: a sphere absorbs over its cross-section and emits over its surface
    integer, parameter :: RING_LANES = 24       ! Rings, the cap included, made up to a multiple of LANES
    integer, parameter :: SEGMENT_LANES = 288   ! Segments, when each ring is made up likewise

    !> The segments of all rings, which do not depend on the place; the cap is the first ring.
    type :: segments_t
        real(dp) :: inner(RING_LANES) = 0, outer(RING_LANES) = 0
        !! Parts of all segments inside the two boundaries between which a ring's centres are half-way
        real(dp) :: cos_azimuth(SEGMENT_LANES) = 0    !! From north towards east; 0 of the cap
        real(dp) :: sin_azimuth(SEGMENT_LANES) = 0
        real(dp) :: exists(SEGMENT_LANES) = 0         !! 1 where there is a segment, else 0
        integer :: rings = 0
        integer :: first(RING_LANES) = 0         !! Segments, with gaps, before those of a ring
        integer :: count(RING_LANES) = 0         !! Of a ring
    end type segments_t

    !> The Earth and the Sun as the satellite has them.
    type :: view_t
        real(dp) :: radius = 0                        !! From the Earth's centre, Earth radii
        real(dp) :: limb_depth = 0                    !! See `limb_depth`
        real(dp) :: up_z = 0, north_z = 0             !! Along the Earth's axis
        real(dp) :: sun_up = 0, sun_north = 0, sun_east = 0   !! Unit vector to the Sun
        real(dp) :: albedo(0:2) = 0, emissivity(0:2) = 0      !! Polynomials in the sine of the latitude
    end type view_t

    !> Where the centres of rings are: half-way between the two boundaries of each
    type :: centres_t
        real(dp) :: cosine(RING_LANES), sine(RING_LANES)      !! Of the angle at the Earth's centre
        real(dp) :: upward(RING_LANES), sideward(RING_LANES)  !! Direction from there to the satellite
    end type centres_t

    type :: earth_radiation_t
        !! The model's constants; built by new_earth_radiation
        real(dp) :: albedo(5) = REPORT_ALBEDO
        !! a0; c0, c1, c2 (constant, cosine, sine of the year); a2: CSR-TM-00-01 eqs. (2-11), (2-13)
        real(dp) :: emissivity(5) = REPORT_EMISSIVITY
        !! e0; k0, k1, k2; e2: CSR-TM-00-01 eqs. (2-12), (2-14)
        real(dp) :: solar_irradiance = DEFAULT_SOLAR_IRRADIANCE     !! E_s at 1 au, W/m^2
        logical :: centres_halve_area = .false.     !! Centres at half of a ring's solid angle, and not at mid-angle
        integer :: segment_count = 1                !! N, the cap included
        type(segments_t), private :: segments       !! N of them
    contains
        procedure :: irradiance_at  !! What the segments send to a place
        procedure :: flux_at        !! The sum of that as a vector
    end type earth_radiation_t

    type :: earth_irradiance_t
        !! What the Earth's segments send to one place; only the first `count` entries count
        integer :: count    !! Number of segments that see the satellite
        real(dp) :: direction(3, MAX_SEGMENTS)
        !! Unit vectors from the segments' centres to the satellite, inertial axes
        real(dp) :: irradiance(MAX_SEGMENTS)    !! On a surface facing the segment, W/m^2
    end type earth_irradiance_t

contains

    !> Rings of 6, 12, 18, ... segments. Two rings (19 segments with the cap) are Knocke's own choice
    !> and the only number with which the Earth radiation curves of CSR-TM-00-01 Figures 5.2 and 5.3
    !> lie in their printed windows; what the 7 of its card `ERADP 1 7` counts is not stated.
    pure function standard_rings(ring_count) result(segments_per_ring)
        integer, intent(in) :: ring_count   !! 0 to MAX_RINGS
        integer :: segments_per_ring(ring_count)

        integer :: i

        segments_per_ring = [(6*i, i=1, ring_count)]
    end function standard_rings

    !> Builds the model. Fails when the name of the constants is not known, when a ring has no
    !> segment or there are too many, and when the irradiance is outside 1 to 10^4 W/m^2.
    subroutine new_earth_radiation(constants, segments_per_ring, solar_irradiance, self, error, centres)
        type(earth_radiation_t), intent(out) :: self
        character(*), intent(in) :: constants
        !! 'report': the cards of CSR-TM-00-01 section 5.2, k1 = -0.17;
        !! 'knocke': the same but for Knocke's own k1 = -0.07;
        !! 'constant-emissivity': the report's albedo with e = e0, which is what the curves of
        !! Figures 5.2 and 5.3 show: its emissivity cards of degree 1 and 2 had no effect there
        integer, intent(in) :: segments_per_ring(:)
        !! From the cap outwards, e.g. standard_rings(1); empty: the cap alone
        real(dp), intent(in) :: solar_irradiance    !! At 1 au, W/m^2, e.g. DEFAULT_SOLAR_IRRADIANCE
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: centres   !! One of SEGMENT_CENTRES; 'mid-angle' when absent

        call check_settings(segments_per_ring, solar_irradiance, error)
        if (allocated(error)) return
        if (present(centres)) then
            if (.not. any(SEGMENT_CENTRES == centres)) then
                call fail_unknown_name(error, 'place of the segments'' centres', centres, SEGMENT_CENTRES)
                return
            end if
            self%centres_halve_area = centres == 'half-solid-angle'
        end if
        call set_constants(self, constants, error)
        if (allocated(error)) return
        self%solar_irradiance = solar_irradiance
        self%segment_count = 1 + sum(segments_per_ring)
        self%segments = segments_of([1, segments_per_ring], self%centres_halve_area)
    end subroutine new_earth_radiation

    subroutine check_settings(segments_per_ring, solar_irradiance, error)
        integer, intent(in) :: segments_per_ring(:)
        real(dp), intent(in) :: solar_irradiance
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: LOW = 1.0_dp, HIGH = 1e4_dp

        if (.not. (solar_irradiance >= LOW .and. solar_irradiance <= HIGH)) then
            call fail_out_of_range(error, 'solar irradiance at 1 au', solar_irradiance, LOW, HIGH, &
                                   'W/m^2')
        else if (size(segments_per_ring) > MAX_RINGS) then
            call fail_out_of_range(error, 'number of rings of the Earth radiation model', &
                                   real(size(segments_per_ring), dp), 0.0_dp, real(MAX_RINGS, dp))
        else if (any(segments_per_ring < 1)) then
            call fail(error, 'segments per ring of the Earth radiation model: every ring needs '// &
                      'at least one segment, but one has '// &
                      integer_text(minval(segments_per_ring)))
        else if (any(segments_per_ring > MAX_SEGMENTS) .or. &
                 sum(segments_per_ring) + 1 > MAX_SEGMENTS) then
            call fail(error, 'segments per ring of the Earth radiation model: with the cap at '// &
                      'most '//integer_text(MAX_SEGMENTS)//' segments are allowed')
        end if
    end subroutine check_settings

    subroutine set_constants(self, constants, error)
        type(earth_radiation_t), intent(inout) :: self
        character(*), intent(in) :: constants
        type(error_t), allocatable, intent(out) :: error

        select case (constants)
        case ('report')
            self%albedo = REPORT_ALBEDO
            self%emissivity = REPORT_EMISSIVITY
        case ('knocke')
            self%albedo = KNOCKE_ALBEDO
            self%emissivity = KNOCKE_EMISSIVITY
        case ('constant-emissivity')
            self%albedo = REPORT_ALBEDO
            self%emissivity = [REPORT_EMISSIVITY(1), 0.0_dp, 0.0_dp, 0.0_dp, 0.0_dp]
        case default
            call fail_unknown_name(error, 'constants of the Earth radiation model', constants, &
                                   EARTH_RADIATION_CONSTANTS)
        end select
    end subroutine set_constants

    !> What depends on the number of segments alone.
    pure function segments_of(count, centres_halve_area) result(segments)
        integer, intent(in) :: count(:)     !! Segments of the cap, 1, and of each ring
        logical, intent(in) :: centres_halve_area
        type(segments_t) :: segments

        integer :: ring, j, lane, before
        real(dp) :: angle

        segments%rings = size(count)
        segments%count(:size(count)) = count
        do ring = 2, size(count)            ! of the cap both boundaries are its centre
            before = sum(count(:ring - 1))
            segments%inner(ring) = before/real(sum(count), dp)
            segments%outer(ring) = (before + count(ring))/real(sum(count), dp)
            if (centres_halve_area) then
                segments%inner(ring) = (segments%inner(ring) + segments%outer(ring))/2
                segments%outer(ring) = segments%inner(ring)
            end if
            segments%first(ring) = segments%first(ring - 1) + lanes_of(count(ring - 1))
        end do
        do ring = 1, size(count)
            do j = 0, count(ring) - 1
                lane = segments%first(ring) + j + 1
                segments%exists(lane) = 1
                if (ring == 1) cycle
                angle = TWO_PI*j/count(ring)
                segments%cos_azimuth(lane) = cos(angle)
                segments%sin_azimuth(lane) = sin(angle)
            end do
        end do
    end function segments_of

    !> The radiation that reaches a satellite, by segments: A' (tau a E_s cos(theta_s) + e M_B),
    !> the sum of CSR-TM-00-01 eq. (2-10) without the satellite's own factors. E_s is that at the
    !> Earth's distance from the Sun (the report has 1 au), the Sun in one direction for the whole Earth; M_B = E_s/4.
    !> The loads on a satellite are sums over segments.
    pure subroutine irradiance_at(self, position, sun_position, days_since_epoch, radiation)
        class(earth_radiation_t), intent(in) :: self
        real(dp), intent(in) :: position(3)
        !! Satellite, above the Earth's surface; inertial axes, z along the Earth's axis, m
        real(dp), intent(in) :: sun_position(3)     !! Sun, same axes, m
        real(dp), intent(in) :: days_since_epoch    !! From EARTH_RADIATION_EPOCH_JD, days
        type(earth_irradiance_t), intent(out) :: radiation

        type(view_t) :: view
        type(centres_t) :: centres
        real(dp) :: axes(3, 3), irradiance, sine, cosine
        integer :: ring, segment, lane

        call look_down(self, position, sun_position, days_since_epoch, view, axes, irradiance)
        call find_centres(self%segments, view, centres)
        radiation%count = self%segment_count
        segment = 0
        do ring = 1, self%segments%rings
            associate (c => centres%cosine(ring), s => centres%sine(ring))
                do lane = self%segments%first(ring) + 1, self%segments%first(ring) + self%segments%count(ring)
                    segment = segment + 1
                    associate (cos_azimuth => self%segments%cos_azimuth(lane), sin_azimuth => self%segments%sin_azimuth(lane))
                        ! A segment's centre lies outward = c up + s (cos A north + sin A east), in radii of the Earth
                        sine = c*view%up_z + s*cos_azimuth*view%north_z
                        cosine = c*view%sun_up + s*(cos_azimuth*view%sun_north + sin_azimuth*view%sun_east)
                        radiation%irradiance(segment) = irradiance*(polynomial(view%albedo, sine)*max(0.0_dp, cosine) + &
                                                                    polynomial(view%emissivity, sine))
                        radiation%direction(:, segment) = centres%upward(ring)*axes(:, 1) + centres%sideward(ring)* &
                                                          (cos_azimuth*axes(:, 2) + sin_azimuth*axes(:, 3))
                    end associate
                end do
            end associate
        end do
    end subroutine irradiance_at

    !> The sum of (2-10) as a vector, without the satellite's own factors: irradiance times direction of all segments of
    !> `irradiance_at`.
    pure subroutine flux_at(self, position, sun_position, days_since_epoch, flux)
        class(earth_radiation_t), intent(in) :: self
        real(dp), intent(in) :: position(3)         !! As for `irradiance_at`
        real(dp), intent(in) :: sun_position(3)     !! Likewise
        real(dp), intent(in) :: days_since_epoch    !! Likewise
        real(dp), intent(out) :: flux(3)            !! Away from the Earth, inertial axes, W/m^2

        type(view_t) :: view
        real(dp) :: axes(3, 3), irradiance, sums(3)

        call look_down(self, position, sun_position, days_since_epoch, view, axes, irradiance)
        call sum_flux(self%segments, view, sums)
        flux = irradiance*transformed(axes, sums)
    end subroutine flux_at

    !> What all segments have in common.
    pure subroutine look_down(self, position, sun_position, days_since_epoch, view, axes, irradiance)
        type(earth_radiation_t), intent(in) :: self
        real(dp), intent(in) :: position(3), sun_position(3), days_since_epoch
        type(view_t), intent(out) :: view
        real(dp), intent(out) :: axes(3, 3)     !! Up, north and east, in its columns
        real(dp), intent(out) :: irradiance     !! The projected area of a segment times sunlight, W/m^2

        real(dp) :: radius, sun_distance, season(3), sun(3)

        radius = sqrt(dot_product(position, position))
        axes(:, 1) = position/radius
        call horizontal_directions(axes(:, 1), axes(:, 2), axes(:, 3))
        sun_distance = sqrt(dot_product(sun_position, sun_position))
        sun = transformed_back(axes, sun_position/sun_distance)
        season = seasonal_terms(days_since_epoch)
        view%radius = radius/EARTH_RADIUS_EGM96
        view%limb_depth = limb_depth(radius)
        view%up_z = axes(3, 1)
        view%north_z = axes(3, 2)
        view%sun_up = sun(1)
        view%sun_north = sun(2)
        view%sun_east = sun(3)
        view%albedo = zonal_polynomial(self%albedo, season)
        view%emissivity = zonal_polynomial(self%emissivity, season)*ABSORBED_TO_EMITTED
        irradiance = 2*view%limb_depth/self%segment_count*self%solar_irradiance*(ASTRONOMICAL_UNIT/sun_distance)**2
    end subroutine look_down

    !> Half-way between the two boundaries of each ring: the direction of the sum of their unit vectors. From there to the
    !> satellite it is `upward` along the satellite's vertical and `sideward` across it, in all 1.
    pure subroutine find_centres(segments, view, centres)
        type(segments_t), intent(in) :: segments
        type(view_t), intent(in) :: view
        type(centres_t), intent(out) :: centres     ! Of the rings that exist

        real(dp) :: x, y, outer_x, outer_y, length, distance
        integer :: ring

        do ring = 1, lanes_of(segments%rings)
            call find_boundary(view, segments%inner(ring), x, y)
            call find_boundary(view, segments%outer(ring), outer_x, outer_y)
            x = x + outer_x
            y = y + outer_y
            length = sqrt(x**2 + y**2)
            x = x/length
            y = y/length
            distance = sqrt((view%radius - x)**2 + y**2)
            centres%cosine(ring) = x
            centres%sine(ring) = y
            centres%upward(ring) = (view%radius - x)/distance
            centres%sideward(ring) = -y/distance
        end do
    end subroutine find_centres

    !> Cosine and sine of the angle beta at the Earth's centre, from the subsatellite point to the boundary that has a part
    !> of all segments inside it. All fill the same solid angle, so the boundary's nadir angle zeta follows from
    !> 1 - cos(zeta) = part (1 - cos(zeta_m)); then beta = gamma - zeta, sin(gamma) = r_s sin(zeta)/R. Of cos(gamma)^2 the
    !> difference to 1 is worked out, since gamma is a right angle at the limb.
    pure subroutine find_boundary(view, part, cosine, sine)
        type(view_t), intent(in) :: view
        real(dp), intent(in) :: part
        real(dp), intent(out) :: cosine, sine

        real(dp) :: depth, cos_zeta, sin_zeta, cos_gamma, sin_gamma

        depth = view%limb_depth*part
        cos_zeta = 1 - depth
        sin_zeta = sqrt(depth*(2 - depth))
        cos_gamma = sqrt(max(0.0_dp, (1 - part)*(2 - view%limb_depth*(1 + part))/(2 - view%limb_depth)))
        sin_gamma = view%radius*sin_zeta
        cosine = cos_gamma*cos_zeta + sin_gamma*sin_zeta
        sine = sin_gamma*cos_zeta - cos_gamma*sin_zeta
    end subroutine find_boundary

    !> The sum over all segments, radiance times direction: along up, north, east.
    pure subroutine sum_flux(segments, view, flux)
        type(segments_t), intent(in) :: segments
        type(view_t), intent(in) :: view
        real(dp), intent(out) :: flux(3)

        type(centres_t) :: centres
        real(dp), dimension(LANES) :: up, north, east
        real(dp) :: sine_up, sine_north, sun_up, sun_north, sun_east, sine, radiance
        integer :: ring, first, lane, i

        call find_centres(segments, view, centres)
        up = 0
        north = 0
        east = 0
        do ring = 1, segments%rings
            sine_up = centres%cosine(ring)*view%up_z
            sine_north = centres%sine(ring)*view%north_z
            sun_up = centres%cosine(ring)*view%sun_up
            sun_north = centres%sine(ring)*view%sun_north
            sun_east = centres%sine(ring)*view%sun_east
            do first = segments%first(ring), segments%first(ring) + segments%count(ring) - 1, LANES
                do lane = 1, LANES
                    i = first + lane
                    sine = sine_up + sine_north*segments%cos_azimuth(i)
                    radiance = polynomial(view%albedo, sine)* &
                               max(0.0_dp, sun_up + sun_north*segments%cos_azimuth(i) + sun_east*segments%sin_azimuth(i)) + &
                               polynomial(view%emissivity, sine)
                    up(lane) = up(lane) + centres%upward(ring)*(radiance*segments%exists(i))
                    north(lane) = north(lane) + centres%sideward(ring)*(radiance*segments%cos_azimuth(i))
                    east(lane) = east(lane) + centres%sideward(ring)*(radiance*segments%sin_azimuth(i))
                end do
            end do
        end do
        flux = [total_of(up), total_of(north), total_of(east)]
    end subroutine sum_flux

    !> 1 - cos(zeta_m), where zeta_m is the nadir angle of the limb, sin(zeta_m) = R/r_s.
    pure real(dp) function limb_depth(radius) result(depth)
        real(dp), intent(in) :: radius      !! Satellite's distance from the Earth's centre, m

        real(dp) :: sin_squared

        sin_squared = (EARTH_RADIUS_EGM96/radius)**2
        depth = sin_squared/(1 + sqrt(max(0.0_dp, 1 - sin_squared)))
    end function limb_depth

    !> North and east at a place; at a pole itself, where there is no north, any two.
    pure subroutine horizontal_directions(up, north, east)
        real(dp), intent(in) :: up(3)                   !! Unit vector, z the Earth's axis
        real(dp), intent(out) :: north(3), east(3)      !! Unit vectors

        real(dp) :: distance_from_axis

        distance_from_axis = sqrt(up(1)**2 + up(2)**2)
        if (distance_from_axis > tiny(1.0_dp)) then
            east = [-up(2), up(1), 0.0_dp]/distance_from_axis
        else
            east = [0.0_dp, 1.0_dp, 0.0_dp]
        end if
        north = [-up(3)*east(2), up(3)*east(1), distance_from_axis]
    end subroutine horizontal_directions

    !> 1, cos W(t-t0), sin W(t-t0) of CSR-TM-00-01 eqs. (2-13), (2-14).
    pure function seasonal_terms(days_since_epoch) result(terms)
        real(dp), intent(in) :: days_since_epoch
        real(dp) :: terms(3)

        real(dp) :: angle

        angle = TWO_PI*days_since_epoch/PERIOD_DAYS
        terms = [1.0_dp, cos(angle), sin(angle)]
    end function seasonal_terms

    !> Albedo or emissivity on a date by latitude, CSR-TM-00-01 eqs. (2-11) to (2-14): the harmonics 1, s, (3 s^2 - 1)/2 as
    !> a polynomial in the sine s of the latitude.
    pure function zonal_polynomial(constants, season) result(coefficients)
        real(dp), intent(in) :: constants(5)
        !! Degree 0; degree 1: constant, cosine, sine of the year; degree 2
        real(dp), intent(in) :: season(3)       !! From seasonal_terms
        real(dp) :: coefficients(0:2)

        coefficients = [constants(1) - constants(5)/2, dot_product(constants(2:4), season), 1.5_dp*constants(5)]
    end function zonal_polynomial

    pure real(dp) function polynomial(coefficients, x) result(value)
        real(dp), intent(in) :: coefficients(0:2), x

        value = coefficients(0) + x*(coefficients(1) + x*coefficients(2))
    end function polynomial
end module gracecg_environment_earth_radiation
