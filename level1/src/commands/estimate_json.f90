!> What the page of a Level-1 estimate shows beyond its results, as members of its JSON: rods, leakage, and the series
!> behind the figures.
module gracecg_level1_estimate_json
    use gracecg_level1_basics
    use gracecg_level1_setup, only: origin_t
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_judgement, only: offset_remark, VERDICTS, REQUIREMENT, UNSEEN
    use gracecg_level1_results, only: find_origins, residual_spectrum_t, fitted_samples, find_spectrum
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_cli_results, only: results_t, put_columns
    implicit none
    private
    public :: put_level1_details, put_level1_tables

    integer, parameter :: MOST_SPANS = 8        !! Whose currents are given
    real(dp), parameter :: LONGEST = 600        !! s, of the currents of a span
    integer, parameter :: MOST_FIELDS = 4000    !! Samples of the field that are given
    real(dp), parameter :: AROUND = 2           !! s, of the currents before and behind a span

contains

    !> What is beside the numbers: limits, leakage, rods, sources in words, notes.
    subroutine put_level1_details(calibration, estimate, results)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        type(results_t), intent(inout) :: results

        type(origin_t), allocatable :: origins(:)
        integer :: i

        call find_origins(calibration, estimate, origins)
        call results%begin_array('origins')
        do i = 1, size(origins)
            call results%begin()
            call results%member('name', trim(origins(i)%name))
            call results%member('value', trim(origins(i)%value))
            call results%member('meaning', trim(origins(i)%meaning))
            call results%member('source', trim(origins(i)%source))
            call results%end()
        end do
        call results%end()
        call results%member('folder', calibration%files%places)
        call results%member('limit_mm', REQUIREMENT/MILLIMETRE)
        call results%member('rod_driven', pack(AXES, estimate%rods%driven))
        call results%member('rod_gain_said', calibration%setup%rod_gain*calibration%setup%rod_sign)
        associate (first => estimate%solutions(1))
            call results%member('remark', trim(offset_remark(first%offset)))
            if (allocated(first%beliefs)) call results%member('unseen', UNSEEN)
            call results%member('leakage', trim(first%leakage))
            call results%member('leakage_separable', first%separable)
            call results%member('leakage_sigma_m_s2_ma', first%leak_sigma)
            call results%member('leakage_rate_sigma_m_s_ma', first%leak_rate_sigma)
            call results%member('determined_least', trim(first%weakest))
        end associate
        call results%begin_array('sources')
        do i = 1, size(estimate%solutions)
            associate (one => estimate%solutions(i))
                call results%begin()
                call results%member('source', trim(one%source))
                call results%member('verdict', trim(VERDICTS(one%flag)))
                call results%member('reason', trim(one%reason))
                call results%member('covariance_mm2', one%covariance/MILLIMETRE**2)
                call results%end()
            end associate
        end do
        call results%end()
        call results%member('notes', [calibration%notes, estimate%remarks])
    end subroutine put_level1_details

    !> The series behind the figures, by columns.
    subroutine put_level1_tables(calibration, estimate, results)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        type(results_t), intent(inout) :: results

        type(residual_spectrum_t) :: spectrum
        real(dp), allocatable :: time(:), observed(:, :), residual(:, :)
        integer, allocatable :: of_span(:), place(:)
        integer :: i, k

        call results%begin('tables')
        allocate (of_span(0), place(0))
        associate (t => calibration%current_time)
            do i = 1, min(MOST_SPANS, size(calibration%spans))
                associate (span => calibration%spans(i))
                    place = [place, pack([(k, k=1, size(t))], t >= span%start - AROUND .and. &
                                          t <= min(span%stop + AROUND, span%start + LONGEST))]
                end associate
                of_span = [of_span, [(i, k=size(of_span) + 1, size(place))]]
            end do
            call results%begin('currents')
            call results%member('span', real(of_span, dp))
            call results%member('time_s', t(place) - calibration%spans(of_span)%start)
            call put_columns(results, 'rod_', '_ma', calibration%current(:, place))
            call results%end()
        end associate
        call put_field(calibration, results)

        call fitted_samples(estimate, 1, time, observed, residual)
        call results%begin('fit')
        call results%member('time_s', time)
        call put_columns(results, 'observed_', '_m_s2', observed)
        call put_columns(results, 'residual_', '_m_s2', residual)
        call results%end()

        call find_spectrum(estimate, spectrum)
        call results%begin('spectrum')
        call results%member('frequency_hz', spectrum%frequency(2:))     ! 0 has no place on a logarithmic axis
        call put_columns(results, '', '_m_s2_sqrt_hz', spectrum%density(:, 2:))
        call results%end()
        call results%begin('spectrum_bands')
        call results%member('frequency_hz', spectrum%band_frequency)
        call put_columns(results, '', '_m_s2_sqrt_hz', spectrum%band_density)
        call results%end()
        call results%end()
    end subroutine put_level1_tables

    !> The field over the spans.
    subroutine put_field(calibration, results)
        type(level1_calibration_t), intent(in) :: calibration
        type(results_t), intent(inout) :: results

        real(dp), allocatable :: time(:), field(:, :)
        integer, allocatable :: of_span(:)
        integer :: i, k, step

        step = 1 + sum([(size(calibration%spans(i)%attitude_time), i=1, size(calibration%spans))])/MOST_FIELDS
        allocate (time(0), field(3, 0), of_span(0))
        do i = 1, size(calibration%spans)
            time = [time, calibration%spans(i)%attitude_time(::step)]
            field = reshape([field, calibration%spans(i)%field(:, ::step)], [3, size(time)])
            of_span = [of_span, [(i, k=size(of_span) + 1, size(time))]]
        end do
        call results%begin('field')
        call results%member('span', real(of_span, dp))
        call results%member('time_min', (time - calibration%spans(1)%start)/60)
        call put_columns(results, '', '_nt', field/NANOTESLA)
        call results%end()
    end subroutine put_field
end module gracecg_level1_estimate_json
