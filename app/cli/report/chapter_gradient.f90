!> The report page: Figure 3.1, the gravity gradient at the proof mass.
module gracecg_cli_chapter_gradient
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_cli_document, only: VERDICT_MET, VERDICT_MISSED
    use gracecg_studies_gravity_gradient, only: gradient_sample_t, largest_components, write_gradient
    use gracecg_cli_panels, only: panel_t, legend_item_t, grid_t, panel_grid, curve
    use gracecg_cli_report_book, only: report_book_t, book_file, add_figure, add_claim, COMMAND
    use gracecg_cli_number_text, only: pick_text, scaled_text
    implicit none
    private
    public :: add_gradient_chapter

    real(dp), parameter :: CENTRAL_SIZE = 1e-9_dp, OTHERS_SIZE = 1e-11_dp   !! m/s^2, section 3.2.2
    character(*), parameter :: FILE = 'gravity_gradient.csv'

contains

    !> Adds the chapter on the gravity gradient.
    subroutine add_gradient_chapter(book, samples, error)
        type(report_book_t), intent(inout) :: book
        type(gradient_sample_t), intent(in) :: samples(:)   !! Front satellite, offset 1 mm
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: central, others
        integer :: kind
        logical :: met

        call write_gradient(book_file(book, FILE), COMMAND, 'front satellite; offset 1 mm, its '// &
                            'components alike', samples, &
                            error)
        if (allocated(error)) return
        call largest_components(samples, central, others)
        met = of_the_order(central, CENTRAL_SIZE) .and. of_the_order(others, OTHERS_SIZE)
        kind = merge(VERDICT_MET, VERDICT_MISSED, met)

        call book%page%chapter('gradient', 'The gravity gradient: Figure 3.1')
        call book%page%paragraph('Outside of the centre of mass the accelerometer feels the gravity '// &
                                 'gradient (3-4). The report keeps that of the central term mu/r alone, '// &
                                 'which makes it (3-6), and shows that all other terms of the '// &
                                 'geopotential together matter a hundred times less: 10^{-9} against '// &
                                 '10^{-11} m/s^{2} for an offset of about 1 mm. Here both are computed '// &
                                 'over one revolution of the front satellite in its nominal attitude, '// &
                                 'with EGM96 to degree and order 20 and an offset of 1 mm whose three '// &
                                 'components are alike. The axes of the printed figure are lost.')
        call add_figure(book, 'figure_3_1', script_of(int(samples(size(samples))%time)), 'Figure '// &
                        '3.1. Disturbing acceleration by the gravity gradient along one revolution: by '// &
                        'the central term (top) and by the sum of all other terms (bottom), in radial, '// &
                        'transverse and normal direction.', &
                       'Figure 3.1, gravity gradient over one revolution', &
                       'Two panels of three curves over 5600 s. By the central term the acceleration is '// &
                       'constant within a few per cent, of the order of 1e-9 m/s^2; by all other terms '// &
                       'it oscillates and stays below '// &
                       scaled_text(others, -11, 1)//'e-11 m/s^2.')
        call book%page%verdict(kind, pick_text(met, 'The orders of magnitude agree.', 'The orders differ.'), &
                               'Largest component by the central term '//scaled_text(central, -9, 2)// &
                               ' x 10^{-9} m/s^{2}, by the others '//scaled_text(others, -11, 2)// &
                               ' x 10^{-11} m/s^{2}. The approximation (3-6) holds.')
        call add_claim(book, 'Figure 3.1', 'figure_3_1', 'the central term gives 10^{-9} m/s^{2}, the '// &
                         'sum of the others 10^{-11}', 'largest component '// &
                       scaled_text(central, -9, 1)//' x 10^{-9} and '// &
                       scaled_text(others, -11, 1)//' x 10^{-11} '// &
                       'm/s^{2}', kind, pick_text(met, 'agrees', 'differs'))
    end subroutine add_gradient_chapter

    !> Within a factor of the square root of ten.
    pure logical function of_the_order(value, order)
        real(dp), intent(in) :: value, order

        of_the_order = abs(log10(value/order)) <= 0.5_dp
    end function of_the_order

    function script_of(duration) result(script)
        integer, intent(in) :: duration     !! s
        character(:), allocatable :: script

        type(panel_t) :: panels(2)
        type(legend_item_t) :: legend(3)
        type(grid_t) :: grid

        grid%panel_height = 230
        grid%x_label = 'time, s'
        grid%x_high = duration
        panels(1)%title = 'central term, 10^{-9} m/s^2'
        panels(1)%curves = curves_of('central', 1e9_dp)
        panels(2)%title = 'sum of all other terms, 10^{-11} m/s^2'
        panels(2)%curves = curves_of('others', 1e11_dp)
        legend(1) = legend_item_t('radial', 1)
        legend(2) = legend_item_t('transverse', 2)
        legend(3) = legend_item_t('normal', 3)
        script = panel_grid(grid, panels, legend)
    end function script_of

    function curves_of(name, factor) result(curves)
        character(*), intent(in) :: name
        real(dp), intent(in) :: factor
        character(:), allocatable :: curves

        character(1), parameter :: DIRECTIONS(3) = ['r', 't', 'n']
        integer :: i

        curves = ''
        do i = 1, 3
            curves = curves//curve(FILE, 'time_s', name//'_'//DIRECTIONS(i)//'_m_s2', i, factor)
        end do
    end function curves_of
end module gracecg_cli_chapter_gradient
